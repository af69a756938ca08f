// The changes that one frame made to the learner's model: enough to repeat them to the last bit
// without the frame's features, labels or training. A few tens of kB per frame; the model's factor
// takes megabytes.
//
// As bytes it is NumPy's .npz (gp/io/array_file.h):
//
//   format_version   i8 [1]       kLearningStepFormat
//   kinds            i8 [k]       operation: 0 add, 1 remove, 2 set the hyperparameters, 3 set the
//                                 labels of all points
//   counts           i8 [k]       added or removed points; 0; labels
//   frames           i8 [k]       of added points; 0
//   inputs           u1 [n, 4 D]  of all added points, one after another: float32, little-endian
//   labels           f8 [...]     of added points, and labels that are set, one after another
//   rows             i8 [r]       of all removed points
//   hyperparameters  f8 [h, P+2]  scales, sigma_f, sigma_n
//   squash           f8 [2]       a, b after the frame
//   location_prior   u1 [...]     state after the frame (location_prior.h)
//   potential        u1 [...]     likewise (potential_model.h); empty where it did not change
//   label_residual   u1 [...]     of the frame (label_residual.h); empty where there is none
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
  std::string potential;       // empty: unchanged
  std::string label_residual;  // empty: none
};

// Equal steps give equal bytes. Errors as SerializeArrays'.
absl::StatusOr<std::string> SerializeStep(const LearningStep& step);

// `covariance`: of the hyperparameters. DataLoss, with the reason, for bytes that are no step of
// `dimension` inputs; Unimplemented for another version of the format.
absl::StatusOr<LearningStep> ParseStep(std::string_view bytes,
                                       kernels::CovarianceFunction covariance, int64_t dimension);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_LEARNING_STEP_H_
