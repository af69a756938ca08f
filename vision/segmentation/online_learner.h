// Updates the Gaussian process with a frame's labels (paper, section IV):
//
//   1. density       thin the new points                                            IV-E, 1
//   2. novelty       keep those that the model gets wrong (all while it is empty)   IV-E, 2
//      add           the factor grows                                               IV-D
//   3. consistency   drop model points that are still classified wrongly; not by default  IV-E, 3
//   4. density       thin the model, newest preferred                               IV-E, 4
//   5. budget        drop the oldest beyond the budget, the rarer class protected
//      remove        points of steps 3 to 5, all at once                            IV-D
//      scale         targets to mean zero, if requested: (T1)                       IV-A
//   6. training      annealing at first, then a few gradient steps                  IV-B
//   7. calibration   a, b by leave-one-out on a stratified sample                   IV-C
//                    or, by default, at places of the frame that the model does not
//                    hold (frame_calibration.h)
//
// A label p becomes the target
//
//   y = (p - p0) / (1 - p0),                                                                (T1)
//
// whose zero, the model's prior mean, is the label p0. The regression returns to it where there
// are no points. Steps 2 and 3 classify by the sign of the mean: a point counts as dynamic where
// its neighbourhood has labels above p0. With p0 = 1/2 the prior is undecided. The paper scales its
// data to mean zero (IV-A): p0 is then the mean label of the model's points, at most 1/2, computed
// anew in every frame.
//
// Step 2 and the paper's step 3 can be switched off. Without the paper's step 3 no prediction of
// the grown model is needed. Steps 4 and 5 are then decided before points are added, so that the
// factor does not grow by points that are dropped at once.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/io/model_file.h"
#include "gp/model/posterior.h"
#include "gp/training/hyperparameter_trainer.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/learner_model.h"
#include "vision/segmentation/selection.h"

namespace egosieve::vision {

struct OnlineLearnerOptions {
  kernels::CovarianceFunction covariance = kernels::CovarianceFunction::kArcsine;
  LearnerModelOptions model;
  double zero_label = 0.5;           // p0 of (T1); in (0, 0.5]
  bool scales_to_mean_zero = false;  // p0 is the mean label of the model's points instead
  bool random_start = false;         // hyperparameters drawn within their bounds, as in the paper
  double new_point_radius = 0.08;    // of step 1
  bool novelty_filter = false;
  bool consistency_filter = false;
  double model_radius = 0.056;  // of step 4
  BudgetOptions budget;
  // Largest number of new points per frame, as a share of the budget: a model of one frame alone
  // forgets movers that stop for a moment. While the model is small, as in the first frames, a
  // frame may exceed it and fill the budget. A stratified random sample of the points is kept; the
  // rest counts as dropped by the budget.
  double arrival_share = 0.5;
  gp::TrainerOptions training;
  int64_t calibration_sample_size = 600;  // points; at least 2
  // True: by frame_calibration.h. False: by leave-one-out, as in the paper. Leave-one-out also
  // serves frames of which nearly all places are in the model.
  bool calibrates_to_frame = true;
  uint64_t seed = 1;

  // Radius of step 1; step 4 gets 0.7 of it.
  void SetDensity(double radius);
  // Largest number of points that a frame may add to a model of `size` points.
  int64_t ArrivalLimit(int64_t size) const;
  absl::Status Validate() const;
};

class OnlineLearner {
 public:
  static absl::StatusOr<std::unique_ptr<OnlineLearner>> Create(
      std::shared_ptr<kernels::Context> context, int64_t input_dimension,
      const OnlineLearnerOptions& options);

  // Steps 1 to 7. inputs: N x D; labels: N, in [0, 1]. Fills the record's fields on selection,
  // model, theta, calibration and their times. After an error the model is valid, but some of the
  // steps may have been taken.
  absl::Status Learn(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                     int64_t frame_index, FrameRecord& record);

  // The fields of the record that describe the present model.
  void Describe(FrameRecord& record) const;

  absl::StatusOr<std::shared_ptr<const gp::Posterior>> MakePosterior() const;

  // The learner's state as a value. The model is rebuilt, so that this learner and one restored
  // from the value continue with the same bits.
  absl::StatusOr<gp::ModelFile> Checkpoint();
  // Errors as those of the parts; then nothing changes.
  absl::Status Restore(const gp::ModelFile& checkpoint);

  const LearnerModel& model() const { return model_; }
  const gp::SquashParameters& squash() const { return squash_; }
  double zero_label() const { return zero_label_; }  // p0 of (T1)
  // Number of bytes of the learner's own annotations, which come first among the checkpoint's
  // annotations.
  int64_t annotation_bytes() const;

 private:
  struct Points {
    std::vector<float> inputs;  // N x D
    std::vector<double> labels;

    int64_t size() const { return static_cast<int64_t>(labels.size()); }
  };

  OnlineLearner(LearnerModel model, gp::HyperparameterTrainer trainer,
                const OnlineLearnerOptions& options);

  absl::StatusOr<std::vector<int64_t>> SelectNewPoints(kernels::ConstMatrixView<float> inputs,
                                                       absl::Span<const double> labels,
                                                       SelectionCounts& counts) const;
  absl::Status UpdatePoints(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                            int64_t frame_index, std::vector<int64_t>& selected,
                            SelectionCounts& counts);
  void LimitArrivals(absl::Span<const double> labels, int64_t frame_index,
                     std::vector<int64_t>& selected) const;
  absl::Status Add(const Points& points, int64_t frame_index);
  absl::Status ScaleToMeanZero();
  std::vector<double> LabelsOf(absl::Span<const double> targets) const;
  // Steps 4 and 5 on the model's rows `alive` and the points about to be added. Both are reduced to
  // the points kept.
  void Thin(int64_t frame_index, std::vector<int64_t>& alive, Points& arriving,
            SelectionCounts& counts) const;
  absl::Status Calibrate();
  absl::Status CalibrateToFrame(kernels::ConstMatrixView<float> inputs,
                                absl::Span<const double> labels, absl::Span<const int64_t> taken,
                                int64_t frame_index);

  OnlineLearnerOptions options_;
  LearnerModel model_;
  gp::HyperparameterTrainer trainer_;
  gp::SquashParameters squash_;
  double zero_label_;
};

}  // namespace egosieve::vision
