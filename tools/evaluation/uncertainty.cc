#include "tools/evaluation/uncertainty.h"

#include <cmath>

namespace egosieve::tools {
namespace {

constexpr int kLevels = RocHistogram::kScores;

// Pixels that are removed together: their number, and the sum of their errors.
struct Group {
  double pixels = 0.0;
  double error = 0.0;
};

double MeanError(double error, double pixels) { return pixels > 0.0 ? error / pixels : 0.0; }

// Groups in the order of their removal.
class Removal {
 public:
  explicit Removal(std::vector<Group> groups) : groups_(std::move(groups)) {
    for (const Group& group : groups_) {
      pixels_ += group.pixels;
      error_ += group.error;
    }
  }

  double pixels() const { return pixels_; }
  double error() const { return error_; }

  // Integral over f of the mean remaining error. Take a group of k pixels with mean error g. Before
  // its removal there are n pixels with error sum E. After removal of x of its pixels the mean is
  // (E - g x)/(n - x):
  //   integral_0^k = g k + (E - g n) log(n / (n - k)),      g k for the last group (E = g n)
  double Area() const {
    double area = 0.0, n = pixels_, e = error_;
    for (size_t i = 0; i < groups_.size(); ++i) {
      const Group& group = groups_[i];
      const double g = group.error / group.pixels;
      const bool last = i + 1 == groups_.size();
      area += g * group.pixels;
      if (!last) area += (e - g * n) * std::log(n / (n - group.pixels));
      n -= group.pixels;
      e -= group.error;
    }
    return area / pixels_;
  }

  // The mean error that remains after the share `removed` is removed.
  double RemainingAfter(double removed) const {
    double leave = removed * pixels_, n = pixels_, e = error_;
    for (const Group& group : groups_) {
      const double part = std::min(leave, group.pixels);
      n -= part;
      e -= part * group.error / group.pixels;
      leave -= part;
      if (!(leave > 0.0)) break;
    }
    return MeanError(e, n);
  }

 private:
  std::vector<Group> groups_;
  double pixels_ = 0.0;
  double error_ = 0.0;
};

Removal ByDeviation(const std::vector<int64_t>& pixels, const std::vector<int64_t>& error_sums) {
  std::vector<Group> groups;
  for (int level = kLevels - 1; level >= 0; --level) {
    if (pixels[level] > 0)
      groups.push_back(
          {static_cast<double>(pixels[level]), static_cast<double>(error_sums[level])});
  }
  return Removal(std::move(groups));
}

Removal ByError(const std::vector<int64_t>& errors) {
  std::vector<Group> groups;
  for (int level = kLevels - 1; level >= 0; --level) {
    if (errors[level] > 0)
      groups.push_back(
          {static_cast<double>(errors[level]), static_cast<double>(errors[level]) * level});
  }
  return Removal(std::move(groups));
}

}  // namespace

UncertaintyHistogram::UncertaintyHistogram(int threshold)
    : threshold_(threshold), pixels_(kLevels), error_sums_(kLevels), errors_(kLevels) {}

void UncertaintyHistogram::Add(uint16_t score, uint16_t deviation, bool positive) {
  const int error = positive ? kLevels - 1 - score : score;
  ++pixels_[deviation];
  error_sums_[deviation] += error;
  ++errors_[error];
  wrong_.Add(deviation, (score >= threshold_) != positive);
}

void UncertaintyHistogram::Merge(const UncertaintyHistogram& other) {
  for (int level = 0; level < kLevels; ++level) {
    pixels_[level] += other.pixels_[level];
    error_sums_[level] += other.error_sums_[level];
    errors_[level] += other.errors_[level];
  }
  wrong_.Merge(other.wrong_);
}

std::optional<double> UncertaintyHistogram::AreaUnderSparsificationError() const {
  const Removal ranked = ByDeviation(pixels_, error_sums_), oracle = ByError(errors_);
  if (!(ranked.error() > 0.0)) return std::nullopt;
  return (ranked.Area() - oracle.Area()) / (ranked.error() / ranked.pixels());
}

std::vector<SparsificationPoint> UncertaintyHistogram::Curve(int points) const {
  const Removal ranked = ByDeviation(pixels_, error_sums_), oracle = ByError(errors_);
  std::vector<SparsificationPoint> curve;
  if (!(ranked.error() > 0.0)) return curve;
  const double all = ranked.error() / ranked.pixels();
  for (int k = 0; k < points; ++k) {
    const double removed = static_cast<double>(k) / points;
    curve.push_back(
        {removed, ranked.RemainingAfter(removed) / all, oracle.RemainingAfter(removed) / all});
  }
  return curve;
}

}  // namespace egosieve::tools
