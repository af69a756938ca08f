// A slow model of the appearance of things that have moved in this drive. Examples: a parked car on
// a street where cars move, a person who waits where others walk.
//
// Its inputs are a place's height in the image and its colour, not its column nor its motion:
//
//   x = (v, I_M, 3 (I_R - I_G), 3 ((I_R + I_G) / 2 - I_B))                                   (Q1)
//
// of the segmenter's descriptor (vision/descriptor/frame_descriptor.h). A label p with enough
// certainty is an observation of a class of -1 or 1 that is known with the probability p:
//
//   y = 2 p - 1,  noise variance r_c (sigma_n^2 + 1 - y^2)                                   (Q2)
//
// where r_c = n_c / min(n_-, n_+) gives both classes the same weight. Standing things that look
// like movers are a small part of all static labels, so that their appearance stays on the movers'
// side.
//
// Memory: every `interval_seconds` a frame's labels replace randomly chosen points of their class,
//
//   n_c interval / min(s_c, memory)  of them, s_c the seconds in which the class was seen    (Q3)
//
// At first the points of a class are therefore a sample of all of its time, later of about the last
// `memory_seconds`. A class that is not seen keeps its points.
//
// The covariance is the squared exponential with fixed hyperparameters. The output is the
// probability Phi(a mu / sqrt(1 + a^2 s^2)) with a = sqrt(pi / 2). To first order it is (1 + mu) /
// 2, and it is 1/2 where nothing similar was seen.
#ifndef EGOSIEVE_VISION_SEGMENTATION_POTENTIAL_MODEL_H_
#define EGOSIEVE_VISION_SEGMENTATION_POTENTIAL_MODEL_H_

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/model/exact_model.h"
#include "gp/model/posterior.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::vision {

struct PotentialOptions {
  bool enabled = false;
  double memory_seconds = 120.0;
  double interval_seconds = 0.5;
  int64_t points_per_class = 600;
  int64_t arrivals = 40;         // largest number per class and frame
  double least_certainty = 0.5;  // of |2 p - 1|; labels below it are ignored; in [0, 1)
  int64_t inducing_points = 96;
  uint64_t seed = 1;

  absl::Status Validate() const;
};

class PotentialModel {
 public:
  static constexpr int kInputs = 4;

  // Options must be valid.
  PotentialModel(std::shared_ptr<kernels::Context> context, const PotentialOptions& options);

  // Learns the labels of the frame at `seconds`. descriptors: N x 6; labels: N, in [0, 1]. Does
  // nothing if the last update is less than an interval ago. Unchanged after an error.
  absl::Status Learn(double seconds, kernels::ConstMatrixView<float> descriptors,
                     absl::Span<const double> labels);

  // Posterior of the present points; null until both classes were seen often enough.
  const std::shared_ptr<const gp::Posterior>& posterior() const { return posterior_; }

  // The state. Equal states give equal bytes and equal posteriors.
  absl::StatusOr<std::string> ToBytes() const;
  // InvalidArgument or DataLoss for bytes that ToBytes did not write; then nothing changes.
  absl::Status Restore(std::string_view bytes);

 private:
  struct State {
    gp::PointSet points;  // targets and noise variances y, 1 - y^2 of (Q2)
    double last_seconds = 0.0;
    int64_t updates = 0;
    std::array<double, 2> class_seconds{};  // s_c of (Q3); 0: static, 1: moving
  };

  // (Q3) with the labels of one class at `rows`; moves: 0 for static, 1 for moving.
  void Replace(int moves, kernels::ConstMatrixView<float> descriptors,
               absl::Span<const double> labels, std::vector<int64_t> rows, State& state) const;
  absl::StatusOr<std::shared_ptr<const gp::Posterior>> Solve(const gp::PointSet& points) const;

  std::shared_ptr<kernels::Context> context_;
  PotentialOptions options_;
  State state_;
  std::shared_ptr<const gp::Posterior> posterior_;
};

// (Q1) of N x 6 descriptors: N x 4.
std::vector<float> AppearanceOf(kernels::ConstMatrixView<float> descriptors);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_POTENTIAL_MODEL_H_
