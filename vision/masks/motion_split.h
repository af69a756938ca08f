// Whether a region moves as one or as two: its flow by one affine motion or by two, each with a
// side of its own.
//
//   cells     blocks of `cell` pixels of the region, c_i = (1, x, y) of their centres, f_i their
//   flow one       A minimising sum rho(|f_i - A c_i|), rho Geman and McClure's (S1) two       A_1,
//   A_2 and labels minimising the same, labels smoothed over neighbouring cells (S2) accepted where
//   cost (S2) < gain * cost (S1), the smaller part has min_share of the cells, each
//             part is mostly one piece, and the motions differ by min_pixels where the parts are
//
// A walking person's limbs do not split: neither part is large and in one piece. Two vehicles whose
// images touch do, if they move differently in the image.
//
// Reference: Wang & Adelson (1994), layers of affine motion.
#ifndef EGOSIEVE_VISION_MASKS_MOTION_SPLIT_H_
#define EGOSIEVE_VISION_MASKS_MOTION_SPLIT_H_

#include <opencv2/core.hpp>

namespace egosieve::vision {

struct MotionSplitOptions {
  int cell_pixels = 4;
  int min_cells = 40;       // of the region; smaller ones are not looked at
  double gain = 0.6;        // in (0, 1)
  double min_share = 0.2;   // in (0, 1/2]
  double min_pixels = 1.5;  // a frame
};

// region: non-zero inside; flow: CV_32FC2. The region's pixels as 1 or 2, 1 the larger part; empty
// where it moves as one.
cv::Mat1b SplitByMotion(const cv::Mat1b& region, const cv::Mat& flow,
                        const MotionSplitOptions& options = {});

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_MOTION_SPLIT_H_
