// How well numbers stay with their movers: IDF1 and HOTA of masks of numbered objects.
//
//   s(i, j)   IoU of object i of the truth and object j of the prediction in one frame
//   IDF1      the one-to-one assignment of whole tracks with the most frames in which s >= 1/2;
//             IDTP of these, IDF1 = 2 IDTP / (truth's objects + predicted objects), summed over
//             frames                                                                         (ID1)
//   HOTA      per frame, the assignment with the largest sum of A(i, j) s(i, j), where
//             m(i, j) = sum over frames of s(i, j) / (sum_k s(i, k) + sum_k s(k, j) - s(i, j)),
//             A = m / (frames of i + frames of j - m); at each a of 0.05, 0.10, ..., 0.95 the pairs
//             with s >= a are true positives TP, the others missed FN or false FP
//             DetA = TP / (TP + FN + FP),  AssA = mean over TP of
//             c / (frames of i + frames of j - c), c the frames in which i and j are a pair
//             HOTA = mean over a of sqrt(DetA AssA)                                          (ID2)
//
// Objects of the truth below `min_area` pixels are left out. So are predicted objects of which more
// than half lies on such objects or on void pixels.
//
// References: Ristani et al. (2016); Luiten et al., HOTA (2021), and its program TrackEval.
#ifndef EGOSIEVE_TOOLS_EVALUATION_IDENTITY_H_
#define EGOSIEVE_TOOLS_EVALUATION_IDENTITY_H_

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace egosieve::tools {

struct IdentityScores {
  double idf1 = 0.0;
  double hota = 0.0;
  double detection = 0.0;     // DetA, mean over a
  double association = 0.0;   // AssA, likewise
  int64_t truth_objects = 0;  // summed over frames
  int64_t predicted_objects = 0;
};

class IdentityScorer {
 public:
  explicit IdentityScorer(int min_area) : min_area_(min_area) {}

  // Numbers of objects, 0: none; all of one size. void_pixels: not 0 where the truth is unknown;
  // may be empty.
  void Add(const cv::Mat1i& truth, const cv::Mat1i& predicted, const cv::Mat1b& void_pixels);

  // Absent if neither has an object.
  std::optional<IdentityScores> Score() const;

 private:
  struct Frame {
    std::vector<int> truth, predicted;  // indices of tracks
    cv::Mat1d similarity;
  };

  int64_t IdentityTruePositives() const;
  cv::Mat1d GlobalAlignment() const;  // A

  int min_area_;
  std::map<int, int> truth_tracks_, predicted_tracks_;  // index by number
  std::vector<int64_t> truth_frames_, predicted_frames_;
  std::vector<Frame> frames_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_IDENTITY_H_
