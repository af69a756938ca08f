#include "tools/compare/block_bootstrap.h"

#include <algorithm>
#include <random>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Sums of `length` values from each start, wrapping around.
std::vector<double> BlockSums(const std::vector<double>& values, int64_t length) {
  const auto count = static_cast<int64_t>(values.size());
  std::vector<double> sums(count, 0.0);
  for (int64_t start = 0; start < count; ++start) {
    for (int64_t k = 0; k < length; ++k) sums[start] += values[(start + k) % count];
  }
  return sums;
}

// One drive's resampled sum: whole blocks, and a last one that may be shorter.
class Drive {
 public:
  Drive(const std::vector<double>& values, int64_t block)
      : count_(static_cast<int64_t>(values.size())), whole_(count_ / std::min(block, count_)) {
    block = std::min(block, count_);
    blocks_ = BlockSums(values, block);
    rest_ = BlockSums(values, count_ - whole_ * block);
  }

  double Resample(std::mt19937_64& random) const {
    double sum = 0.0;
    for (int64_t i = 0; i < whole_; ++i) sum += blocks_[Draw(random)];
    return sum + rest_[Draw(random)];
  }

 private:
  // The bias of the modulus is under count / 2^64.
  size_t Draw(std::mt19937_64& random) const {
    return static_cast<size_t>(random() % static_cast<uint64_t>(count_));
  }

  int64_t count_ = 0;
  int64_t whole_ = 0;
  std::vector<double> blocks_;
  std::vector<double> rest_;
};

double Quantile(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<size_t>(place);
  const size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (place - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

}  // namespace

absl::Status BootstrapOptions::Validate() const {
  if (block_frames < 1 || resamples < 40) {
    return absl::InvalidArgumentError(
        absl::StrFormat("block_frames = %d, resamples = %d; they must be at least 1 and 40",
                        block_frames, resamples));
  }
  return absl::OkStatus();
}

std::optional<BootstrapInterval> BlockBootstrap(const std::vector<std::vector<double>>& differences,
                                                const BootstrapOptions& options) {
  BootstrapInterval interval;
  std::vector<Drive> drives;
  double sum = 0.0;
  for (const std::vector<double>& drive : differences) {
    if (drive.empty()) continue;
    drives.emplace_back(drive, options.block_frames);
    interval.frames += static_cast<int64_t>(drive.size());
    for (const double value : drive) sum += value;
  }
  if (drives.empty()) return std::nullopt;
  const auto frames = static_cast<double>(interval.frames);
  interval.mean = sum / frames;
  std::mt19937_64 random(options.seed);
  std::vector<double> means;
  for (int i = 0; i < options.resamples; ++i) {
    double resampled = 0.0;
    for (const Drive& drive : drives) resampled += drive.Resample(random);
    means.push_back(resampled / frames);
    interval.share_positive += means.back() > 0.0 ? 1.0 : means.back() == 0.0 ? 0.5 : 0.0;
  }
  interval.share_positive /= options.resamples;
  std::sort(means.begin(), means.end());
  interval.low = Quantile(means, 0.025);
  interval.high = Quantile(means, 0.975);
  return interval;
}

}  // namespace egosieve::tools
