// What one frame did to the learner's model: enough to do it again without the frame's features,
// labels or training, to the last bit. A few tens of kB a frame, where the model's factor is
// megabytes.
//
// As bytes it is NumPy's .npz (gp/io/array_file.h):
//
//   format_version   i8 [1]       kLearningStepFormat
//   kinds            i8 [k]       operation: 0 add, 1 remove, 2 set the hyperparameters, 3 set the
//                                 labels of all points
//   counts           i8 [k]       added or removed points; 0; labels
//   frames           i8 [k]       of added points; 0
//   inputs           u1 [n, 4 D]  of all added points, one after another: float32, little-endian
//   labels           f8 [...]     of added points, and those that are set, one after another
//   rows             i8 [r]       of all removed points
//   hyperparameters  f8 [h, P+2]  scales, sigma_f, sigma_n
//   squash           f8 [2]       a, b after the frame
//   location_prior   u1 [...]     state after the frame (location_prior.h)
//   potential        u1 [...]     likewise (potential_model.h); empty where nothing changed it
//   label_residual   u1 [...]     of the frame (label_residual.h); empty where it has none
#ifndef EGOSIEVE_VISION_SEGMENTATION_LEARNING_STEP_H_
#define EGOSIEVE_VISION_SEGMENTATION_LEARNING_STEP_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "vision/segmentation/learner_model.h"

namespace egosieve::vision {

inline constexpr int64_t kLearningStepFormat = 4;

struct LearningStep {
  std::vector<ModelOperation> operations;
  gp::SquashParameters squash;
  std::string location_prior;
  std::string potential;       // empty: as before
  std::string label_residual;  // empty: none
};

// Equal steps give equal bytes. Errors as SerializeArrays'.
absl::StatusOr<std::string> SerializeStep(const LearningStep& step);

// `covariance`: of the hyperparameters. DataLoss, saying what, for bytes that are no step of
// `dimension` inputs; Unimplemented for those of a later version.
absl::StatusOr<LearningStep> ParseStep(std::string_view bytes,
                                       kernels::CovarianceFunction covariance, int64_t dimension);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_LEARNING_STEP_H_
