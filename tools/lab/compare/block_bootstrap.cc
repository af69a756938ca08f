#include "tools/lab/compare/block_bootstrap.h"

#include <algorithm>
#include <random>
#include <utility>

#include "absl/strings/str_format.h"
#include "vision/statistics/order_statistics.h"

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

int64_t BlockLength(int64_t frames, const BootstrapOptions& options) {
  constexpr int64_t kFewestBlocks = 3;
  return std::min<int64_t>(options.block_frames, std::max<int64_t>(1, frames / kFewestBlocks));
}

// Resampled sums of one drive: whole blocks, and a last block that may be shorter.
class Drive {
 public:
  Drive(const std::vector<double>& values, int64_t block)
      : count_(static_cast<int64_t>(values.size())), whole_(count_ / block) {
    blocks_ = BlockSums(values, block);
    rest_ = BlockSums(values, count_ - whole_ * block);
  }

  double Resample(std::mt19937_64& random) const {
    double sum = 0.0;
    for (int64_t i = 0; i < whole_; ++i) sum += blocks_[Draw(random)];
    return sum + rest_[Draw(random)];
  }

 private:
  // The modulus has a bias below count / 2^64.
  size_t Draw(std::mt19937_64& random) const {
    return static_cast<size_t>(random() % static_cast<uint64_t>(count_));
  }

  int64_t count_ = 0;
  int64_t whole_ = 0;
  std::vector<double> blocks_;
  std::vector<double> rest_;
};

// Sets the interval from the resampled figures; its other fields are set before.
void SetQuantiles(std::vector<double> resampled, BootstrapInterval& interval) {
  double positive = 0.0;
  for (const double value : resampled) positive += value > 0.0 ? 1.0 : value == 0.0 ? 0.5 : 0.0;
  interval.share_positive = positive / static_cast<double>(resampled.size());
  std::sort(resampled.begin(), resampled.end());
  interval.low = vision::InterpolatedQuantile(resampled, 0.025);
  interval.high = vision::InterpolatedQuantile(resampled, 0.975);
}

// A drive's frame numbers minus their mean, and the residuals of its figures.
struct CentredDrive {
  std::vector<double> time;
  std::vector<double> residual;
};

CentredDrive Centre(const std::vector<FrameFigure>& frames) {
  double time = 0.0, value = 0.0;
  for (const FrameFigure& frame : frames) {
    time += frame.frame;
    value += frame.value;
  }
  const auto count = static_cast<double>(frames.size());
  CentredDrive drive;
  for (const FrameFigure& frame : frames) {
    drive.time.push_back(frame.frame - time / count);
    drive.residual.push_back(frame.value - value / count);
  }
  return drive;
}

// sum t e, with the residuals e resampled by blocks.
double ResampledProduct(const CentredDrive& drive, int64_t block, std::mt19937_64& random) {
  const size_t count = drive.time.size();
  double product = 0.0;
  size_t source = 0;
  for (size_t i = 0; i < count; ++i) {
    source = i % static_cast<size_t>(block) == 0 ? static_cast<size_t>(random() % count)
                                                 : (source + 1) % count;
    product += drive.time[i] * drive.residual[source];
  }
  return product;
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
    drives.emplace_back(drive, BlockLength(static_cast<int64_t>(drive.size()), options));
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
  }
  SetQuantiles(std::move(means), interval);
  return interval;
}

std::optional<BootstrapInterval> SequenceBootstrap(const std::vector<double>& differences,
                                                   const BootstrapOptions& options) {
  if (differences.empty()) return std::nullopt;
  const size_t count = differences.size();
  BootstrapInterval interval;
  interval.frames = static_cast<int64_t>(count);
  for (const double value : differences) interval.mean += value / static_cast<double>(count);
  std::mt19937_64 random(options.seed);
  std::vector<double> means;
  for (int i = 0; i < options.resamples; ++i) {
    double sum = 0.0;
    for (size_t k = 0; k < count; ++k) sum += differences[random() % count];
    means.push_back(sum / static_cast<double>(count));
  }
  SetQuantiles(std::move(means), interval);
  return interval;
}

std::optional<BootstrapInterval> SlopeBootstrap(const std::vector<std::vector<FrameFigure>>& drives,
                                                const BootstrapOptions& options) {
  constexpr size_t kFewestFrames = 3;
  BootstrapInterval interval;
  std::vector<CentredDrive> centred;
  double product = 0.0, square = 0.0;
  for (const std::vector<FrameFigure>& frames : drives) {
    if (frames.size() < kFewestFrames) continue;
    centred.push_back(Centre(frames));
    interval.frames += static_cast<int64_t>(frames.size());
    for (size_t i = 0; i < frames.size(); ++i) {
      product += centred.back().time[i] * centred.back().residual[i];
      square += centred.back().time[i] * centred.back().time[i];
    }
  }
  if (!(square > 0.0)) return std::nullopt;
  interval.mean = product / square;
  for (CentredDrive& drive : centred) {
    for (size_t i = 0; i < drive.time.size(); ++i) {
      drive.residual[i] -= interval.mean * drive.time[i];
    }
  }
  std::mt19937_64 random(options.seed);
  std::vector<double> slopes;
  for (int i = 0; i < options.resamples; ++i) {
    double resampled = 0.0;
    for (const CentredDrive& drive : centred) {
      const auto frames = static_cast<int64_t>(drive.time.size());
      resampled += ResampledProduct(drive, BlockLength(frames, options), random);
    }
    slopes.push_back(interval.mean + resampled / square);
  }
  SetQuantiles(std::move(slopes), interval);
  return interval;
}

}  // namespace egosieve::tools
