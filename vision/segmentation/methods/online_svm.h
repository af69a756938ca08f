// A support vector machine in place of the Gaussian process: the same filters, budget and points
// (online_learner.h, steps 1 to 5), then
//
//   6. training      the machine is trained anew on at most `training_points` of the kept points, a
//                    sample that protects the rarer class; kernel and cost by cross-validation at
//                    the first training and every `parameter_interval` frames
//   7. calibration   Platt's sigmoid on cross-validated decision values of a stratified sample
//
// A point is positive if its label is 1/2 or more. The filters take the machine's sign as its
// prediction. Until both classes have been seen there is no machine: the probability is that of
// Platt's targets, (N+ + 1) / (N + 2).
#ifndef EGOSIEVE_VISION_SEGMENTATION_METHODS_ONLINE_SVM_H_
#define EGOSIEVE_VISION_SEGMENTATION_METHODS_ONLINE_SVM_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"
#include "vision/baselines/platt_sigmoid.h"
#include "vision/baselines/svm_classifier.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/online_learner.h"

namespace egosieve::vision {

struct OnlineSvmOptions {
  OnlineLearnerOptions learner;  // filters, budget, sample sizes, seed; the rest is unused
  int64_t training_points = 1500;
  int parameter_interval = 50;  // in learnt frames
  int folds = 3;
};

class OnlineSvm {
 public:
  explicit OnlineSvm(const OnlineSvmOptions& options) : options_(options) {}

  // inputs: N x D; labels: N, in [0, 1].
  absl::Status Learn(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                     int64_t frame_index, FrameRecord& record);
  std::vector<float> Probability(kernels::ConstMatrixView<float> queries) const;

  int64_t size() const { return static_cast<int64_t>(labels_.size()); }

 private:
  void Append(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
              absl::Span<const int64_t> rows, int64_t frame_index);
  void Keep(absl::Span<const int64_t> rows);
  kernels::ConstMatrixView<float> View() const;
  // 0, 1/2 or 1 by the machine's sign, for the filters to compare with the labels.
  std::vector<float> Predictions(kernels::ConstMatrixView<float> points) const;

  absl::StatusOr<std::vector<int64_t>> SelectNew(kernels::ConstMatrixView<float> inputs,
                                                 absl::Span<const double> labels,
                                                 int64_t frame_index,
                                                 SelectionCounts& counts) const;
  absl::Status Thin(int64_t frame_index, SelectionCounts& counts);
  absl::Status Train();
  absl::Status Calibrate();
  std::vector<int64_t> Sample(int64_t count) const;

  OnlineSvmOptions options_;
  int64_t dimension_ = 0;
  std::vector<float> inputs_;
  std::vector<double> labels_;
  std::vector<int64_t> births_;
  std::optional<SvmClassifier> machine_;
  SvmParameters parameters_;
  PlattSigmoid sigmoid_{0.0, 0.0};
  int64_t trainings_ = 0;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_METHODS_ONLINE_SVM_H_
