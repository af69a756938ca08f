#include "vision/segmentation/potential_model.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/io/model_file.h"
#include "gp/model/sparse_model.h"
#include "kernels/base/splitmix.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

constexpr float kChromaScale = 3.0f;   // in (Q1)
constexpr double kLengthScale = 1.2;   // of every input
constexpr double kNoiseStddev = 0.5;   // sigma_n
constexpr int64_t kFewestPoints = 20;  // of either class, before there is a posterior
const gp::SquashParameters kSquash{std::sqrt(M_PI / 2.0), 0.0};

gp::Hyperparameters FixedHyperparameters() {
  gp::Hyperparameters hyperparameters = gp::DefaultHyperparameters(
      kernels::CovarianceFunction::kSquaredExponential, PotentialModel::kInputs);
  hyperparameters.covariance.scales.assign(PotentialModel::kInputs, kLengthScale);
  hyperparameters.covariance.signal_stddev = 1.0;
  hyperparameters.noise_stddev = kNoiseStddev;
  return hyperparameters;
}

// Uniform in [0, 1), determined by the constructor's arguments alone.
class Draws {
 public:
  Draws(uint64_t seed, int64_t update, int moves)
      : state_(kernels::SplitMix(seed) ^ (2 * static_cast<uint64_t>(update) + moves)) {}

  double Next() {
    state_ += kernels::kSplitMixStep;
    return static_cast<double>(kernels::SplitMix(state_) >> 11) * 0x1p-53;
  }
  int64_t Below(int64_t count) {
    return std::min(count - 1, static_cast<int64_t>(Next() * static_cast<double>(count)));
  }

 private:
  uint64_t state_;
};

std::vector<int64_t> RowsOfClass(const gp::PointSet& points, int moves) {
  std::vector<int64_t> rows;
  for (int64_t i = 0; i < points.size(); ++i) {
    if ((points.targets[i] >= 0.0) == (moves == 1)) rows.push_back(i);
  }
  return rows;
}

}  // namespace

absl::Status PotentialOptions::Validate() const {
  const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  if (!positive(memory_seconds) || !positive(interval_seconds)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("potential: memory_seconds = %g, interval_seconds = %g; both must be "
                        "positive and finite",
                        memory_seconds, interval_seconds));
  }
  if (points_per_class < kFewestPoints || arrivals < 1 || inducing_points < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("potential: points_per_class = %d, arrivals = %d, inducing_points = %d; "
                        "they must be at least %d, 1 and 1",
                        points_per_class, arrivals, inducing_points, kFewestPoints));
  }
  if (!(least_certainty >= 0.0 && least_certainty < 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("potential: least_certainty = %g; it must be in [0, 1)", least_certainty));
  }
  return absl::OkStatus();
}

std::vector<float> AppearanceOf(kernels::ConstMatrixView<float> descriptors) {
  std::vector<float> appearance;
  appearance.reserve(descriptors.rows * PotentialModel::kInputs);
  for (int64_t i = 0; i < descriptors.rows; ++i) {
    const float* x = descriptors.row(i);
    const float red = x[3], green = x[4], blue = x[5];
    appearance.insert(appearance.end(), {x[1], x[2], kChromaScale * (red - green),
                                         kChromaScale * (0.5f * (red + green) - blue)});
  }
  return appearance;
}

PotentialModel::PotentialModel(std::shared_ptr<kernels::Context> context,
                               const PotentialOptions& options)
    : context_(std::move(context)), options_(options) {
  state_.last_seconds = -options.interval_seconds;
}

absl::Status PotentialModel::Learn(double seconds, kernels::ConstMatrixView<float> descriptors,
                                   absl::Span<const double> labels) {
  if (state_.updates > 0 && std::abs(seconds - state_.last_seconds) < options_.interval_seconds) {
    return absl::OkStatus();
  }
  std::array<std::vector<int64_t>, 2> rows;
  for (int64_t i = 0; i < descriptors.rows; ++i) {
    if (std::abs(2.0 * labels[i] - 1.0) < options_.least_certainty) continue;
    rows[labels[i] >= 0.5].push_back(i);
  }
  if (rows[0].empty() && rows[1].empty()) return absl::OkStatus();
  State next = state_;
  for (const int moves : {0, 1}) {
    if (!rows[moves].empty()) {
      Replace(moves, descriptors, labels, std::move(rows[moves]), next);
    }
  }
  next.last_seconds = seconds;
  ++next.updates;
  EGOSIEVE_ASSIGN_OR_RETURN(posterior_, Solve(next.points));
  state_ = std::move(next);
  return absl::OkStatus();
}

void PotentialModel::Replace(int moves, kernels::ConstMatrixView<float> descriptors,
                             absl::Span<const double> labels, std::vector<int64_t> rows,
                             State& state) const {
  Draws draws(options_.seed, state.updates, moves);
  const double interval = options_.interval_seconds;
  state.class_seconds[moves] += interval;
  const std::vector<int64_t> held = RowsOfClass(state.points, moves);
  const auto size = static_cast<int64_t>(held.size());
  const double share = interval / std::min(state.class_seconds[moves], options_.memory_seconds);
  const double due = share * static_cast<double>(options_.points_per_class) + draws.Next();
  const int64_t room = options_.points_per_class - size;
  const int64_t count = std::min({std::max(static_cast<int64_t>(due), room), options_.arrivals,
                                  static_cast<int64_t>(rows.size())});
  // The first `count` of a random order, for both the candidates and the points to remove.
  const auto shuffle = [&](std::vector<int64_t>& numbers, int64_t first) {
    for (int64_t i = 0; i < first; ++i) {
      std::swap(numbers[i], numbers[i + draws.Below(static_cast<int64_t>(numbers.size()) - i)]);
    }
    numbers.resize(first);
    std::sort(numbers.begin(), numbers.end());
  };
  shuffle(rows, count);
  std::vector<int64_t> gone = held;
  shuffle(gone, std::max<int64_t>(0, count - room));
  std::vector<float> chosen;
  std::vector<double> targets, noise_variances;
  for (const int64_t row : rows) {
    chosen.insert(chosen.end(), descriptors.row(row), descriptors.row(row) + descriptors.cols);
    const double y = 2.0 * labels[row] - 1.0;
    targets.push_back(y);
    noise_variances.push_back(1.0 - y * y);
  }
  const std::vector<float> appearance = AppearanceOf({chosen.data(), count, descriptors.cols});
  const std::vector<double> inputs(appearance.begin(), appearance.end());
  state.points.Remove(gone);
  state.points.Append({{inputs.data(), count, kInputs}, targets, noise_variances}, state.updates);
}

absl::StatusOr<std::shared_ptr<const gp::Posterior>> PotentialModel::Solve(
    const gp::PointSet& points) const {
  std::array<int64_t, 2> counts{};
  for (const double y : points.targets) ++counts[y >= 0.0];
  const int64_t rarer = std::min(counts[0], counts[1]);
  if (rarer < kFewestPoints) return std::shared_ptr<const gp::Posterior>();
  gp::ExactModelState model{FixedHyperparameters(), points};
  const double noise = model.hyperparameters.noise_variance();
  for (int64_t i = 0; i < points.size(); ++i) {
    const double ratio = static_cast<double>(counts[points.targets[i] >= 0.0]) / rarer;
    double& variance = model.points.noise_variances[i];
    variance = ratio * (noise + variance) - noise;  // (Q2)
  }
  gp::SparseModelOptions sparse;
  sparse.inducing_points = options_.inducing_points;
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel solved,
                            gp::SparseModel::Restore(context_, model, sparse));
  return solved.MakePosterior(kSquash);
}

absl::StatusOr<std::string> PotentialModel::ToBytes() const {
  gp::ModelFile file;
  file.model = {FixedHyperparameters(), state_.points};
  file.squash = kSquash;
  const std::array<double, 4> numbers = {state_.last_seconds, static_cast<double>(state_.updates),
                                         state_.class_seconds[0], state_.class_seconds[1]};
  file.annotations.assign(reinterpret_cast<const char*>(numbers.data()), sizeof(numbers));
  return gp::SerializeModel(file);
}

absl::Status PotentialModel::Restore(std::string_view bytes) {
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::ModelFile file, gp::ParseModel(bytes));
  std::array<double, 4> numbers{};
  if (file.annotations.size() != sizeof(numbers) ||
      file.model.hyperparameters.covariance.input_dimension() != kInputs) {
    return absl::InvalidArgumentError("the state of the potential is not whole");
  }
  std::memcpy(numbers.data(), file.annotations.data(), sizeof(numbers));
  const bool whole = std::isfinite(numbers[0]) &&
                     std::all_of(numbers.begin() + 1, numbers.end(),
                                 [](double number) { return number >= 0.0 && number < 0x1p53; });
  const gp::PointSet& points = file.model.points;
  if (!whole || points.outputs != 1 || points.noise_variances.size() != points.targets.size()) {
    return absl::InvalidArgumentError("the state of the potential is not whole");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(posterior_, Solve(points));
  state_ = {points, numbers[0], static_cast<int64_t>(numbers[1]), {numbers[2], numbers[3]}};
  return absl::OkStatus();
}

}  // namespace egosieve::vision
