#include "vision/segmentation/methods/map_method.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "vision/baselines/dense_flow.h"
#include "vision/baselines/nearest_feature.h"
#include "vision/baselines/optical_flow_classifier.h"
#include "vision/descriptor/frame_descriptor.h"
#include "vision/segmentation/label_residual.h"
#include "vision/segmentation/methods/online_svm.h"
#include "vision/segmentation/online_learner.h"
#include "vision/segmentation/stage_timer.h"

namespace egosieve::vision {
namespace {

constexpr double kHalfScorePixels = 3.0;

SegmentationMap EmptyMap(const MethodInput& input) {
  SegmentationMap map;
  map.frame_index = input.frame_index;
  map.grid = input.grid;
  map.probability.assign(input.grid.size(), 0.0f);
  return map;
}

std::vector<double> ScoresOf(const std::vector<double>& distances) {
  std::vector<double> scores;
  scores.reserve(distances.size());
  for (const double distance : distances) scores.push_back(ScoreOfDistance(distance));
  return scores;
}

Eigen::Matrix3d MatrixOf(const LabelledFrame& labels) {
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) matrix(i, j) = labels.motion_matrix(i, j);
  }
  return matrix;
}

class GaussianProcessMethod : public MapMethod {
 public:
  GaussianProcessMethod(std::unique_ptr<OnlineLearner> learner, double residual_weight)
      : learner_(std::move(learner)), residual_weight_(residual_weight) {}

  bool probabilistic() const override { return true; }

  absl::StatusOr<SegmentationMap> Answer(const MethodInput& input, FrameRecord& record) override {
    if (input.inputs.rows > 0) {
      const absl::Status status =
          learner_->Learn(input.inputs, input.labels->probability, input.frame_index, record);
      if (kernels::IsOfTheMachine(status)) return status;
      record.learnt = status.ok();
      if (!status.ok())
        record.reason = absl::StrCat("the model could not learn: ", status.message());
      posterior_.reset();
    }
    learner_->Describe(record);
    if (posterior_ == nullptr) {
      StageTimer timer(record.milliseconds.posterior);
      EGOSIEVE_ASSIGN_OR_RETURN(posterior_, learner_->MakePosterior());
    }
    StageTimer timer(record.milliseconds.inference);
    SegmentationMap map = EmptyMap(input);
    map.mean.resize(input.grid.size());
    map.deviation.resize(input.grid.size());
    kernels::PosteriorOutputs outputs;
    outputs.mean = map.mean.data();
    outputs.variance = map.deviation.data();
    outputs.probability = map.probability.data();
    EGOSIEVE_ASSIGN_OR_RETURN(const kernels::PosteriorCounts counts,
                              posterior_->Evaluate(input.field, outputs));
    for (float& value : map.deviation) value = std::sqrt(value);
    map.clamped_variances = record.clamped_variances = counts.clamped_variances;
    if (record.learnt && residual_weight_ > 0.0) EGOSIEVE_RETURN_IF_ERROR(AddResidual(input, map));
    return map;
  }

 private:
  // The same as in OnlineSegmenter.
  absl::Status AddResidual(const MethodInput& input, SegmentationMap& map) const {
    const LabelledFrame& labels = *input.labels;
    if (labels.size() == 0 || labels.labelled.index != input.frame_index) return absl::OkStatus();
    std::vector<float> own(labels.size());
    kernels::PosteriorOutputs outputs;
    outputs.probability = own.data();
    EGOSIEVE_RETURN_IF_ERROR(posterior_->Evaluate(input.inputs, outputs).status());
    LabelResidual(input.frame_index, labels.labelled.image.size(), labels.positions_view(),
                  labels.probability, own)
        .Apply(residual_weight_, map);
    return absl::OkStatus();
  }

  std::unique_ptr<OnlineLearner> learner_;
  double residual_weight_;
  std::shared_ptr<const gp::Posterior> posterior_;  // of the present model; null: to be made
};

class SvmMethod : public MapMethod {
 public:
  explicit SvmMethod(const OnlineSvmOptions& options) : svm_(options) {}

  bool probabilistic() const override { return true; }

  absl::StatusOr<SegmentationMap> Answer(const MethodInput& input, FrameRecord& record) override {
    if (input.inputs.rows > 0) {
      const absl::Status status =
          svm_.Learn(input.inputs, input.labels->probability, input.frame_index, record);
      if (kernels::IsOfTheMachine(status)) return status;
      record.learnt = status.ok();
      if (!status.ok())
        record.reason = absl::StrCat("the model could not learn: ", status.message());
    }
    record.model_size = svm_.size();
    StageTimer timer(record.milliseconds.inference);
    SegmentationMap map = EmptyMap(input);
    if (svm_.size() > 0) map.probability = svm_.Probability(input.field);
    return map;
  }

 private:
  OnlineSvm svm_;
};

// A value at each labelled feature; each pixel takes the value of its nearest feature.
class NearestFeatureMethod : public MapMethod {
 public:
  using Values = absl::StatusOr<std::vector<double>> (*)(const MethodInput& input);

  NearestFeatureMethod(Values values, bool probabilistic)
      : values_(values), probabilistic_(probabilistic) {}

  bool probabilistic() const override { return probabilistic_; }

  absl::StatusOr<SegmentationMap> Answer(const MethodInput& input, FrameRecord& record) override {
    StageTimer timer(record.milliseconds.inference);
    SegmentationMap map = EmptyMap(input);
    if (input.labels->size() == 0) return map;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> values, values_(input));
    const std::vector<double> places = PlacesInFrame(*input.labels);
    map.probability = SpreadToGrid({places.data(), input.labels->size(), 2}, values, input.grid);
    record.learnt = true;
    return map;
  }

 private:
  Values values_;
  bool probabilistic_;
};

absl::StatusOr<std::vector<double>> LabelValues(const MethodInput& input) {
  return input.labels->probability;
}

absl::StatusOr<std::vector<double>> RansacValues(const MethodInput& input) {
  return ScoresOf(input.labels->residual_pixels);
}

absl::StatusOr<std::vector<double>> OpticalFlowValues(const MethodInput& input) {
  const LabelledFrame& labels = *input.labels;
  EGOSIEVE_ASSIGN_OR_RETURN(
      const OpticalFlowClassification classification,
      ClassifyOpticalFlow(PairsOf(labels), labels.motion_model, MatrixOf(labels), input.grid.width,
                          input.grid.height, {}));
  return ScoresOf(classification.violation_pixels);
}

// The distance of the dense flow at each pixel of the grid.
class DenseFlowMethod : public MapMethod {
 public:
  using Distances = absl::StatusOr<std::vector<double>> (*)(const DenseFlow& flow,
                                                            const MethodInput& input,
                                                            uint64_t seed);

  DenseFlowMethod(Distances distances, uint64_t seed) : distances_(distances), seed_(seed) {}

  bool probabilistic() const override { return false; }

  absl::StatusOr<SegmentationMap> Answer(const MethodInput& input, FrameRecord& record) override {
    StageTimer timer(record.milliseconds.inference);
    SegmentationMap map = EmptyMap(input);
    if (input.grey_before.empty()) return map;
    EGOSIEVE_ASSIGN_OR_RETURN(const DenseFlow flow,
                              FlowAtGrid(input.grey_before, input.grey, input.grid));
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<double> distances,
        distances_(flow, input, seed_ + static_cast<uint64_t>(input.frame_index)));
    if (distances.empty()) return map;
    for (size_t i = 0; i < distances.size(); ++i) {
      map.probability[i] = static_cast<float>(ScoreOfDistance(distances[i]));
    }
    record.learnt = true;
    return map;
  }

 private:
  Distances distances_;
  uint64_t seed_;
};

absl::StatusOr<std::vector<double>> HomographyFlow(const DenseFlow& flow, const MethodInput&,
                                                   uint64_t seed) {
  return HomographyDistances(flow, seed);
}

absl::StatusOr<std::vector<double>> DenseViolations(const DenseFlow& flow, const MethodInput& input,
                                                    uint64_t seed) {
  EGOSIEVE_ASSIGN_OR_RETURN(const MotionModel model, FundamentalMatrixOf(flow, seed));
  if (model.kind == MotionModelKind::kNone) return std::vector<double>();
  EGOSIEVE_ASSIGN_OR_RETURN(OpticalFlowClassification classification,
                            ClassifyOpticalFlow(flow.pairs, model.kind, model.matrix,
                                                input.grid.width, input.grid.height, {}));
  return std::move(classification.violation_pixels);
}

absl::StatusOr<std::unique_ptr<MapMethod>> MakeProcess(std::shared_ptr<kernels::Context> context,
                                                       const OnlineSegmenterOptions& options,
                                                       kernels::CovarianceFunction covariance) {
  OnlineLearnerOptions of_learner = options.learner;
  of_learner.covariance = covariance;
  EGOSIEVE_ASSIGN_OR_RETURN(
      std::unique_ptr<OnlineLearner> learner,
      OnlineLearner::Create(std::move(context), kDescriptorDimension, of_learner));
  return std::make_unique<GaussianProcessMethod>(std::move(learner), options.residual_weight);
}

}  // namespace

double ScoreOfDistance(double distance_pixels) {
  if (!(distance_pixels > 0.0)) return 0.0;
  return std::isinf(distance_pixels) ? 1.0 : distance_pixels / (distance_pixels + kHalfScorePixels);
}

std::vector<double> PlacesInFrame(const LabelledFrame& labels) {
  return labels.labelled.index == labels.frame_index ? labels.positions : labels.other_positions;
}

const std::vector<MethodName>& MethodNames() {
  static const auto& names = *new std::vector<MethodName>{
      {"arcsine", "Gaussian process, arcsine covariance"},
      {"squared_exponential", "Gaussian process, squared-exponential covariance"},
      {"svm", "support vector machine, same framework"},
      {"labels", "labels of the nearest features"},
      {"ransac", "RANSAC distance of the nearest features"},
      {"optical_flow", "optical-flow classification of the nearest features"},
      {"dense_optical_flow", "optical-flow classification of dense flow"},
      {"homography_flow", "distance of dense flow to a homography"},
  };
  return names;
}

absl::StatusOr<std::unique_ptr<MapMethod>> MakeMethod(const std::string& name,
                                                      std::shared_ptr<kernels::Context> context,
                                                      const OnlineSegmenterOptions& options) {
  const uint64_t seed = options.labeller.seed;
  using kernels::CovarianceFunction;
  if (name == "arcsine")
    return MakeProcess(std::move(context), options, CovarianceFunction::kArcsine);
  if (name == "squared_exponential")
    return MakeProcess(std::move(context), options, CovarianceFunction::kSquaredExponential);
  if (name == "svm") {
    EGOSIEVE_RETURN_IF_ERROR(options.Validate());
    OnlineSvmOptions svm;
    svm.learner = options.learner;
    return std::make_unique<SvmMethod>(svm);
  }
  if (name == "labels") return std::make_unique<NearestFeatureMethod>(LabelValues, true);
  if (name == "ransac") return std::make_unique<NearestFeatureMethod>(RansacValues, false);
  if (name == "optical_flow")
    return std::make_unique<NearestFeatureMethod>(OpticalFlowValues, false);
  if (name == "dense_optical_flow") return std::make_unique<DenseFlowMethod>(DenseViolations, seed);
  if (name == "homography_flow") return std::make_unique<DenseFlowMethod>(HomographyFlow, seed);
  return absl::NotFoundError(absl::StrCat(
      "no method '", name, "'; the methods are ",
      absl::StrJoin(MethodNames(), ", ", [](std::string* out, const MethodName& method) {
        absl::StrAppend(out, method.name);
      })));
}

}  // namespace egosieve::vision
