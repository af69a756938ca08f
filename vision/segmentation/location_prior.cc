#include "vision/segmentation/location_prior.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/geometry/motion_model.h"
#include "vision/image/bilinear.h"
#include "vision/image/cell_grid.h"

namespace egosieve::vision {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");

constexpr CellGrid kCells{.columns = 64, .rows = 36};
constexpr double kReach = 2.0;        // deviation of the blur of d, in cells
constexpr double kPriorFrames = 4.0;  // n0
constexpr double kDynamic = 0.5;      // labels from this value on count

// Interpolation between cell centres: linear, constant beyond the outermost centres.
Around<float> AmongCells(int pixel, int size, int cells) {
  const Around<double> around = AroundClamped((pixel + 0.5) / size * cells - 0.5, cells);
  return {around.low, around.high, static_cast<float>(around.share)};
}

}  // namespace

LocationPrior::LocationPrior(const LocationPriorOptions& options)
    : options_(options), labels_(kCells.size(), 0.0f) {}

void LocationPrior::Learn(const LabelledFrame& labels) {
  if (labels.size() == 0 || labels.motion_model == MotionModelKind::kStatic) return;
  Add(labels.labelled.image.size(), labels.positions_view(), labels.probability);
}

void LocationPrior::Add(cv::Size size, kernels::ConstMatrixView<double> positions,
                        absl::Span<const double> labels) {
  if (options_.weight == 0.0) return;
  for (float& sum : labels_) sum *= static_cast<float>(options_.memory);
  frames_ = options_.memory * frames_ + 1.0;
  for (int64_t i = 0; i < positions.rows; ++i) {
    if (labels[i] < kDynamic) continue;
    const double* at = positions.row(i);
    labels_[kCells.IndexAt(at[0] / size.width * kCells.columns,
                           at[1] / size.height * kCells.rows)] += static_cast<float>(labels[i]);
  }
}

void LocationPrior::Apply(SegmentationMap& map) const {
  const double sum = std::accumulate(labels_.begin(), labels_.end(), 0.0);
  if (!(sum > 0.0)) return;
  const double mean = sum / static_cast<double>(labels_.size());
  cv::Mat1f factor(kCells.rows, kCells.columns);
  std::copy(labels_.begin(), labels_.end(), factor.begin());
  cv::GaussianBlur(factor, factor, {}, kReach, kReach, cv::BORDER_REFLECT);
  for (float& value : factor) {
    const double ratio = (frames_ * value / mean + kPriorFrames) / (frames_ + kPriorFrames);
    value = static_cast<float>(std::pow(ratio, options_.weight));
  }
  const ImageGrid& grid = map.grid;
  for (int row = 0; row < grid.rows(); ++row) {
    const Around<float> y = AmongCells(grid.y_pixels(row), grid.height, kCells.rows);
    for (int column = 0; column < grid.columns(); ++column) {
      const Around<float> x = AmongCells(grid.x_pixels(column), grid.width, kCells.columns);
      const float odds_factor =
          BilinearByDifferences(x, y, [&](int r, int c) { return factor(r, c); });
      float& p = map.probability[static_cast<size_t>(row) * grid.columns() + column];
      p = p * odds_factor / (1.0f - p + p * odds_factor);
    }
  }
}

std::string LocationPrior::ToBytes() const {
  std::string bytes(sizeof(frames_) + labels_.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), &frames_, sizeof(frames_));
  std::memcpy(bytes.data() + sizeof(frames_), labels_.data(), labels_.size() * sizeof(float));
  return bytes;
}

absl::Status LocationPrior::Restore(std::string_view bytes) {
  double frames = 0.0;
  std::vector<float> labels(labels_.size());
  if (bytes.size() != sizeof(frames) + labels.size() * sizeof(float)) {
    return absl::InvalidArgumentError("the state of the location prior is of another size");
  }
  std::memcpy(&frames, bytes.data(), sizeof(frames));
  std::memcpy(labels.data(), bytes.data() + sizeof(frames), labels.size() * sizeof(float));
  const auto is_sum = [](double value) { return std::isfinite(value) && value >= 0.0; };
  if (!is_sum(frames) || !std::all_of(labels.begin(), labels.end(), is_sum)) {
    return absl::InvalidArgumentError("the state of the location prior is not whole");
  }
  frames_ = frames;
  labels_ = std::move(labels);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
