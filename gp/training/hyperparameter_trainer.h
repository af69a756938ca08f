// Online training of the hyperparameters (paper, section IV-B), in rounds: in the first simulated
// annealing and many gradient steps, then a few gradient steps per round, starting from the
// previous round's values.
//
//   J(theta) = 1/|S| ( log p(y_S | X_S, theta)
//                      - 1/2 sum_t ((theta_t - theta0_t) / prior_stddev)^2 )
//
// S is a stratified subset of the model's points, drawn anew in each round: at most `subset_size`.
// J is a mean over points, so that step sizes do not depend on |S|. theta stays within bounds.
//
// When theta has settled, training is reduced: while the smoothed movement per round is under
// `settled_movement`, steps are taken in every `settled_interval`-th round only. Every settled
// round checks J on a subset of `annealing_subset_size` points. If J falls by more than
// 0.1 below the running mean of these checks, full training resumes. The mean contains
// checks alone, since J depends on |S|: with more points, each is predicted better. A J that is not
// finite enters no mean.
//
// All random choices depend on the seed and the number of rounds. The state is a small
// plain struct, and a trainer restored from it continues with the same bits.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "gp/training/trainer_steps.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct TrainerOptions {
  int64_t subset_size = 800;            // |S| of gradient steps, points
  int64_t annealing_subset_size = 300;  // |S| of the annealing and of settled rounds' checks
  double minimum_class_share = 0.25;    // of S, for the rarer class if it has enough points
  int64_t annealing_evaluations = 150;  // in the first round
  int64_t initial_gradient_steps = 25;  // after annealing; 2 in each later round
  double prior_stddev = 3.0;            // of log theta around theta0; infinity: no prior
  double rebuild_threshold = 0.05;      // see ShouldRebuild
  double settled_movement = 0.005;      // largest |change of theta_t| per round
  int64_t settled_interval = 5;         // rounds
  uint64_t seed = 1;

  absl::Status Validate() const;
};

// The complete state of a trainer.
struct TrainerState {
  std::vector<double> theta;
  RpropState optimiser;
  int64_t rounds = 0;  // in which training was possible
  int64_t rounds_since_step = 0;
  double smoothed_movement = 1.0;
  // Mean of J in the checks since theta settled; none before the first.
  std::optional<double> smoothed_objective;
};

class HyperparameterTrainer {
 public:
  // theta0 = ToLogarithms(initial): start and centre of the prior.
  static absl::StatusOr<HyperparameterTrainer> Create(const Hyperparameters& initial,
                                                      const HyperparameterBounds& bounds,
                                                      const TrainerOptions& options = {});

  // One round, on the model's points, of one output. If it is impossible (too few points, one class)
  // or ends in an error, nothing changes.
  absl::Status Train(kernels::Context& context, const Observations& points);

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }

  // True if any logarithm of theta differs from that of `used` (the model's) by more than
  // rebuild_threshold; the factor should then be rebuilt.
  bool ShouldRebuild(const Hyperparameters& used) const;

  const TrainerState& state() const { return state_; }
  // InvalidArgument, unchanged, if sizes or values do not fit.
  absl::Status Restore(const TrainerState& state);

 private:
  HyperparameterTrainer() = default;

  // J on a subset, and its gradient if requested. An indefinite matrix gives -infinity.
  absl::StatusOr<double> Objective(kernels::Context& context, const PointSet& subset,
                                   const std::vector<double>& theta,
                                   std::vector<double>* gradient) const;
  PointSet Draw(const Observations& points, int64_t size, uint64_t seed) const;

  Hyperparameters hyperparameters_;
  std::vector<double> prior_centre_;
  HyperparameterBounds bounds_;
  TrainerOptions options_;
  TrainerState state_;
};

}  // namespace egosieve::gp
