// The segmenter and the methods it is compared with, behind one interface: from the labelled
// features of a frame to a map. All methods get the same features, labels, descriptors and grid.
//
//   name                  memory   the map
//   arcsine               yes      Gaussian process, arcsine covariance (the segmenter itself)
//   squared_exponential   yes      the same with the squared-exponential covariance
//   svm                   yes      support vector machine in the same incremental framework
//   labels                no       label of the feature nearest to each pixel
//   ransac                no       distance of the nearest feature to the motion model
//   optical_flow          no       violation at the nearest feature (optical_flow_classifier.h)
//   dense_optical_flow    no       violation of each pixel's own dense flow
//   homography_flow       no       distance of each pixel's dense flow to a homography
//
// Distances d become scores d / (d + 3 px): strictly increasing, and 1/2 at the largest plausible
// distance of the paper. These scores are not probabilities. Methods without memory give 0
// everywhere in a frame without labels. The location prior (location_prior.h) is not part of a
// method: method_segmenter.h applies it to all of them.
#ifndef EGOSIEVE_VISION_SEGMENTATION_METHODS_MAP_METHOD_H_
#define EGOSIEVE_VISION_SEGMENTATION_METHODS_MAP_METHOD_H_

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

// A method's input for one frame.
struct MethodInput {
  int64_t frame_index = 0;
  const LabelledFrame* labels = nullptr;  // never null; may have no labels
  // Equalised grey pictures of the frame and of the pair's first frame; the latter is empty without
  // a pair.
  cv::Mat grey, grey_before;
  kernels::ConstMatrixView<float> inputs;  // N x 6, of the labelled places
  kernels::ConstMatrixView<float> field;   // grid.size() x 6, of the frame
  kernels::ImageGrid grid;
};

class MapMethod {
 public:
  virtual ~MapMethod() = default;

  // Frames in order. Fills the record's fields on selection, model and calibration and their times,
  // including that of the map. The deviation is left empty where the method has none.
  virtual absl::StatusOr<SegmentationMap> Answer(const MethodInput& input, FrameRecord& record) = 0;
  // Whether its scores are meant as probabilities.
  virtual bool probabilistic() const = 0;
};

struct MethodName {
  const char* name;
  const char* summary;
};

// In the order for listings.
const std::vector<MethodName>& MethodNames();

// NotFound, with a list of the names, for an unknown name.
absl::StatusOr<std::unique_ptr<MapMethod>> MakeMethod(const std::string& name,
                                                      std::shared_ptr<kernels::Context> context,
                                                      const OnlineSegmenterOptions& options);

// The labelled features' places in the frame itself, N x 2.
std::vector<double> PlacesInFrame(const LabelledFrame& labels);

// d / (d + 3 px).
double ScoreOfDistance(double distance_pixels);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_METHODS_MAP_METHOD_H_
