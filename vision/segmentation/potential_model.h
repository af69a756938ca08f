// What has moved before: a slow model of what looks like the things that move in this drive. A
// parked car on a street where cars move, somebody who waits where people walk.
//
// It sees of a place its height in the image and its colour, not where beside others it lies, nor
// that it moves:
//
//   x = (v, I_M, 3 (I_R - I_G), 3 ((I_R + I_G) / 2 - I_B))                                   (Q1)
//
// of the segmenter's descriptor (kernels/ops/descriptor_field.h). A label p that is sure is an
// observation of a class of -1 or 1 that is known with the probability p:
//
//   y = 2 p - 1,  noise variance r_c (sigma_n^2 + 1 - y^2)                                   (Q2)
//
// where r_c = n_c / min(n_-, n_+) makes both classes weigh the same. What stands is a small part of
// all that is labelled static, so that what looks like a mover stays on the movers' side.
//
// Memory: every `interval_seconds` a frame's labels replace points of their class at random,
//
//   n_c interval / min(s_c, memory)  of them, s_c the seconds in which the class was seen    (Q3)
//
// so that the points of a class are a sample over all of its time at first and over about
// `memory_seconds` later. A class that is not seen forgets nothing.
//
// The covariance is the squared exponential with fixed hyperparameters. The answer is the
// probability Phi(a mu / sqrt(1 + a^2 s^2)) with a = sqrt(pi / 2), by which it is (1 + mu) / 2 to
// first order: 1/2 where nothing alike was seen.
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
  int64_t arrivals = 40;         // of a class in one frame at most
  double least_certainty = 0.5;  // of |2 p - 1|; labels below it are passed over; in [0, 1)
  int64_t inducing_points = 96;
  uint64_t seed = 1;

  absl::Status Validate() const;
};

class PotentialModel {
 public:
  static constexpr int kInputs = 4;

  // Options must be valid.
  PotentialModel(std::shared_ptr<kernels::Context> context, const PotentialOptions& options);

  // The labels of a frame at `seconds`. descriptors: N x 6; labels: N, in [0, 1]. Nothing where the
  // last update is less than an interval ago. Unchanged after an error.
  absl::Status Learn(double seconds, kernels::ConstMatrixView<float> descriptors,
                     absl::Span<const double> labels);

  // Of the points as they are; null before both classes were seen.
  const std::shared_ptr<const gp::Posterior>& posterior() const { return posterior_; }

  // The state; equal states give equal bytes, and with them equal posteriors.
  absl::StatusOr<std::string> ToBytes() const;
  // InvalidArgument or DataLoss for bytes that ToBytes did not write; unchanged then.
  absl::Status Restore(std::string_view bytes);

  // Whether Learn has changed the model since the last call.
  bool TakeChanged();

 private:
  struct State {
    gp::PointSet points;  // targets and noise variances y, 1 - y^2 of (Q2)
    double last_seconds = 0.0;
    int64_t updates = 0;
    std::array<double, 2> class_seconds{};  // s_c of (Q3); 0: static, 1: moving
  };

  // (Q3) with the labels of one class at `rows`.
  void Replace(int moves, kernels::ConstMatrixView<float> descriptors,
               absl::Span<const double> labels, std::vector<int64_t> rows, State& state) const;
  absl::StatusOr<std::shared_ptr<const gp::Posterior>> Solve(const gp::PointSet& points) const;

  std::shared_ptr<kernels::Context> context_;
  PotentialOptions options_;
  State state_;
  std::shared_ptr<const gp::Posterior> posterior_;
  bool changed_ = false;
};

// (Q1) of N x 6 descriptors: N x 4.
std::vector<float> AppearanceOf(kernels::ConstMatrixView<float> descriptors);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_POTENTIAL_MODEL_H_
