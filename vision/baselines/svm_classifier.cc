#include "vision/baselines/svm_classifier.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

constexpr int kMaximumIterations = 20000;
constexpr double kTolerance = 1e-3;
constexpr double kGammas[] = {0.5, 2.0, 8.0, 32.0};
constexpr double kCosts[] = {1.0, 10.0};

cv::Mat1f AsMat(kernels::ConstMatrixView<float> view) {
  return cv::Mat1f(static_cast<int>(view.rows), static_cast<int>(view.cols),
                   const_cast<float*>(view.data), view.stride * sizeof(float));
}

bool HasBothClasses(const std::vector<uint8_t>& positive) {
  const auto is_positive = [](uint8_t p) { return p != 0; };
  return std::any_of(positive.begin(), positive.end(), is_positive) &&
         !std::all_of(positive.begin(), positive.end(), is_positive);
}

// Points of one fold, or all others.
struct Part {
  std::vector<float> inputs;
  std::vector<uint8_t> positive;
  std::vector<int64_t> rows;

  kernels::ConstMatrixView<float> view(int64_t dimension) const {
    return {inputs.data(), static_cast<int64_t>(rows.size()), dimension};
  }
};

Part Take(kernels::ConstMatrixView<float> inputs, const std::vector<uint8_t>& positive, int fold,
          int folds, bool inside) {
  Part part;
  for (int64_t row = 0; row < inputs.rows; ++row) {
    if ((row % folds == fold) != inside) continue;
    part.inputs.insert(part.inputs.end(), inputs.row(row), inputs.row(row) + inputs.cols);
    part.positive.push_back(positive[row]);
    part.rows.push_back(row);
  }
  return part;
}

// Sum of the error rates of both classes.
double BalancedError(const std::vector<double>& decisions, const std::vector<uint8_t>& positive) {
  double wrong[2] = {0.0, 0.0}, count[2] = {0.0, 0.0};
  for (size_t i = 0; i < decisions.size(); ++i) {
    const int own = positive[i] != 0 ? 1 : 0;
    count[own] += 1.0;
    wrong[own] += (decisions[i] > 0.0) != (own == 1) ? 1.0 : 0.0;
  }
  return wrong[0] / std::max(count[0], 1.0) + wrong[1] / std::max(count[1], 1.0);
}

}  // namespace

absl::Status SvmParameters::Validate() const {
  for (const auto& [name, value] : {std::pair{"gamma", gamma}, std::pair{"c", c}}) {
    if (!(value > 0.0) || std::isinf(value)) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, " = ", value, "; it must be positive and finite"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<SvmClassifier> SvmClassifier::Train(kernels::ConstMatrixView<float> inputs,
                                                   const std::vector<uint8_t>& positive,
                                                   const SvmParameters& parameters) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  if (inputs.rows != static_cast<int64_t>(positive.size())) {
    return absl::InvalidArgumentError(
        absl::StrCat(inputs.rows, " points and ", positive.size(), " classes"));
  }
  if (!HasBothClasses(positive)) {
    return absl::FailedPreconditionError(
        absl::StrCat(positive.size(), " points of one class; a support vector machine needs both"));
  }
  cv::Mat1i classes(static_cast<int>(inputs.rows), 1);
  for (int64_t i = 0; i < inputs.rows; ++i) classes(static_cast<int>(i)) = positive[i] != 0 ? 1 : 0;
  try {
    cv::Ptr<cv::ml::SVM> machine = cv::ml::SVM::create();
    machine->setType(cv::ml::SVM::C_SVC);
    machine->setKernel(cv::ml::SVM::RBF);
    machine->setGamma(parameters.gamma);
    machine->setC(parameters.c);
    machine->setTermCriteria(cv::TermCriteria(cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS,
                                              kMaximumIterations, kTolerance));
    machine->train(AsMat(inputs), cv::ml::ROW_SAMPLE, classes);
    return SvmClassifier(std::move(machine));
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("the support vector machine failed: ", error.what()));
  }
}

std::vector<double> SvmClassifier::Decide(kernels::ConstMatrixView<float> queries) const {
  std::vector<double> decisions(queries.rows);
  if (queries.rows == 0) return decisions;
  cv::Mat1f raw;
  machine_->predict(AsMat(queries), raw, cv::ml::StatModel::RAW_OUTPUT);
  // OpenCV's value is positive for the first class, 0.
  for (int64_t i = 0; i < queries.rows; ++i) decisions[i] = -raw(static_cast<int>(i));
  return decisions;
}

absl::StatusOr<std::vector<double>> CrossValidatedDecisions(kernels::ConstMatrixView<float> inputs,
                                                            const std::vector<uint8_t>& positive,
                                                            const SvmParameters& parameters,
                                                            int folds) {
  std::vector<double> decisions(positive.size(), 0.0);
  for (int fold = 0; fold < folds; ++fold) {
    const Part rest = Take(inputs, positive, fold, folds, false);
    const Part held = Take(inputs, positive, fold, folds, true);
    if (!HasBothClasses(rest.positive) || held.rows.empty()) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(
        const SvmClassifier machine,
        SvmClassifier::Train(rest.view(inputs.cols), rest.positive, parameters));
    const std::vector<double> own = machine.Decide(held.view(inputs.cols));
    for (size_t i = 0; i < own.size(); ++i) decisions[held.rows[i]] = own[i];
  }
  return decisions;
}

absl::StatusOr<SvmParameters> ChooseSvmParameters(kernels::ConstMatrixView<float> inputs,
                                                  const std::vector<uint8_t>& positive, int folds) {
  SvmParameters best;
  double least = 3.0;
  for (const double gamma : kGammas) {
    for (const double c : kCosts) {
      const SvmParameters candidate{gamma, c};
      EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> decisions,
                                CrossValidatedDecisions(inputs, positive, candidate, folds));
      const double error = BalancedError(decisions, positive);
      if (error < least) {
        least = error;
        best = candidate;
      }
    }
  }
  return best;
}

}  // namespace egosieve::vision
