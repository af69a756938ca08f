#include "vision/segmentation/learning_step.h"

#include <bit>
#include <cstring>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "gp/io/array_file.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

static_assert(std::endian::native == std::endian::little, "float32 is written as it lies");

using Kind = ModelOperation::Kind;

template <typename T>
gp::NamedArray Matrix(std::vector<T> elements, int64_t columns) {
  const int64_t size = static_cast<int64_t>(elements.size());
  return {{columns > 0 ? size / columns : 0, columns}, std::move(elements)};
}

template <typename T>
absl::StatusOr<std::vector<T>> Take(const std::string& name, gp::ArrayMap& arrays) {
  const auto found = arrays.find(name);
  if (found == arrays.end()) return absl::DataLossError(absl::StrCat("no array ", name));
  auto* elements = std::get_if<std::vector<T>>(&found->second.elements);
  if (elements == nullptr)
    return absl::DataLossError(absl::StrCat("array ", name, " has another type"));
  return std::move(*elements);
}

// Reads an array's elements from front to back.
template <typename T>
class Reader {
 public:
  explicit Reader(std::vector<T> elements) : elements_(std::move(elements)) {}

  template <typename Target>
  bool Read(int64_t count, std::vector<Target>& target) {
    if (count < 0 || count > static_cast<int64_t>(elements_.size() - place_) *
                                 static_cast<int64_t>(sizeof(T)) /
                                 static_cast<int64_t>(sizeof(Target))) {
      return false;
    }
    target.resize(count);
    if (count > 0) std::memcpy(target.data(), elements_.data() + place_, count * sizeof(Target));
    place_ += count * sizeof(Target) / sizeof(T);
    return true;
  }
  bool at_end() const { return place_ == elements_.size(); }

 private:
  std::vector<T> elements_;
  size_t place_ = 0;
};

absl::StatusOr<std::string> TakeText(const std::string& name, gp::ArrayMap& arrays) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<uint8_t> bytes, Take<uint8_t>(name, arrays));
  return std::string(bytes.begin(), bytes.end());
}

// What all operations take, one after the other.
struct OperationReader {
  Reader<uint8_t> inputs;
  Reader<double> labels, hyperparameters;
  Reader<int64_t> rows;

  // Reads what an operation of its kind has; false if there is less.
  bool Read(int64_t count, kernels::CovarianceFunction covariance, int64_t dimension,
            ModelOperation& operation) {
    switch (operation.kind) {
      case Kind::kAdd:
        return labels.Read(count, operation.labels) &&
               inputs.Read(count * dimension, operation.inputs);
      case Kind::kRemove:
        return rows.Read(count, operation.rows);
      case Kind::kSetLabels:
        return labels.Read(count, operation.labels);
      case Kind::kSetHyperparameters:
        return ReadHyperparameters(covariance, dimension, operation.hyperparameters);
    }
    return false;
  }
  bool at_end() const {
    return inputs.at_end() && labels.at_end() && hyperparameters.at_end() && rows.at_end();
  }

 private:
  bool ReadHyperparameters(kernels::CovarianceFunction covariance, int64_t dimension,
                           gp::Hyperparameters& theta) {
    theta.covariance.function = covariance;
    const int64_t scales = covariance.description().ScaleCount(dimension);
    std::vector<double> stddevs;
    if (!hyperparameters.Read(scales, theta.covariance.scales) ||
        !hyperparameters.Read(2, stddevs)) {
      return false;
    }
    theta.covariance.signal_stddev = stddevs[0];
    theta.noise_stddev = stddevs[1];
    return true;
  }
};

absl::StatusOr<OperationReader> ReaderOf(gp::ArrayMap& arrays) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<uint8_t> inputs, Take<uint8_t>("inputs", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<double> labels, Take<double>("labels", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<int64_t> rows, Take<int64_t>("rows", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<double> theta, Take<double>("hyperparameters", arrays));
  return OperationReader{Reader<uint8_t>(std::move(inputs)), Reader<double>(std::move(labels)),
                         Reader<double>(std::move(theta)), Reader<int64_t>(std::move(rows))};
}

}  // namespace

absl::StatusOr<std::string> SerializeStep(const LearningStep& step) {
  std::vector<int64_t> kinds, counts, frames, rows;
  std::vector<uint8_t> inputs;
  std::vector<double> labels, hyperparameters;
  int64_t input_bytes = 0, parameters = 0;
  for (const ModelOperation& operation : step.operations) {
    kinds.push_back(static_cast<int64_t>(operation.kind));
    frames.push_back(operation.frame);
    counts.push_back(static_cast<int64_t>(operation.labels.size() + operation.rows.size()));
    const auto* bytes = reinterpret_cast<const uint8_t*>(operation.inputs.data());
    const size_t size = operation.inputs.size() * sizeof(float);
    inputs.insert(inputs.end(), bytes, bytes + size);
    if (operation.kind == Kind::kAdd && !operation.labels.empty())
      input_bytes = static_cast<int64_t>(size / operation.labels.size());
    labels.insert(labels.end(), operation.labels.begin(), operation.labels.end());
    rows.insert(rows.end(), operation.rows.begin(), operation.rows.end());
    if (operation.kind == Kind::kSetHyperparameters) {
      const gp::Hyperparameters& theta = operation.hyperparameters;
      hyperparameters.insert(hyperparameters.end(), theta.covariance.scales.begin(),
                             theta.covariance.scales.end());
      hyperparameters.push_back(theta.covariance.signal_stddev);
      hyperparameters.push_back(theta.noise_stddev);
      parameters = theta.count();
    }
  }
  gp::ArrayMap arrays;
  arrays["format_version"] = gp::VectorArray<int64_t>({kLearningStepFormat});
  arrays["kinds"] = gp::VectorArray(std::move(kinds));
  arrays["counts"] = gp::VectorArray(std::move(counts));
  arrays["frames"] = gp::VectorArray(std::move(frames));
  arrays["inputs"] = Matrix(std::move(inputs), input_bytes);
  arrays["labels"] = gp::VectorArray(std::move(labels));
  arrays["rows"] = gp::VectorArray(std::move(rows));
  arrays["hyperparameters"] = Matrix(std::move(hyperparameters), parameters);
  arrays["squash"] = gp::VectorArray<double>({step.squash.a, step.squash.b});
  arrays["location_prior"] =
      gp::VectorArray<uint8_t>({step.location_prior.begin(), step.location_prior.end()});
  arrays["potential"] = gp::VectorArray<uint8_t>({step.potential.begin(), step.potential.end()});
  arrays["label_residual"] =
      gp::VectorArray<uint8_t>({step.label_residual.begin(), step.label_residual.end()});
  return gp::SerializeArrays(arrays);
}

absl::StatusOr<LearningStep> ParseStep(std::string_view bytes,
                                       kernels::CovarianceFunction covariance, int64_t dimension) {
  EGOSIEVE_ASSIGN_OR_RETURN(gp::ArrayMap arrays, gp::ParseArrays(bytes));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> version,
                            Take<int64_t>("format_version", arrays));
  if (version != std::vector<int64_t>{kLearningStepFormat}) {
    return absl::UnimplementedError("a step of another version of this format");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> kinds, Take<int64_t>("kinds", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> counts, Take<int64_t>("counts", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> frames, Take<int64_t>("frames", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(OperationReader reader, ReaderOf(arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> squash, Take<double>("squash", arrays));
  LearningStep step;
  EGOSIEVE_ASSIGN_OR_RETURN(step.location_prior, TakeText("location_prior", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(step.potential, TakeText("potential", arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(step.label_residual, TakeText("label_residual", arrays));
  if (counts.size() != kinds.size() || frames.size() != kinds.size() || squash.size() != 2) {
    return absl::DataLossError("the arrays' sizes do not fit");
  }
  step.squash = {squash[0], squash[1]};
  for (size_t i = 0; i < kinds.size(); ++i) {
    ModelOperation operation;
    operation.kind = static_cast<Kind>(kinds[i]);
    operation.frame = frames[i];
    if (!reader.Read(counts[i], covariance, dimension, operation)) {
      return absl::DataLossError(absl::StrCat("operation ", i, " is not whole"));
    }
    step.operations.push_back(std::move(operation));
  }
  if (!reader.at_end()) return absl::DataLossError("more points than the operations take");
  return step;
}

}  // namespace egosieve::vision
