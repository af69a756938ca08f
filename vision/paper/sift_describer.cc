#include "vision/paper/sift_describer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "kernels/base/parallel_for.h"
#include "vision/paper/feature_set.h"

namespace egosieve::vision {
namespace {

constexpr float kFirstSigma = 0.8F;
constexpr float kCameraBlur = 0.5F;  // pixels; blur that the input pictures are assumed to have
constexpr int kSmallestSide = 12;    // of an octave, samples
constexpr int kCells = 4, kOrientations = 8;
// Grey levels: 16 rounding errors of 255 in float. Blurring leaves up to six in a flat picture.
constexpr double kRounding = 0x1p-12;
constexpr float kCellWidth = 3.0F;  // in sigmas
constexpr float kLargestEntry = 0.2F;
constexpr float kToBytes = 512.0F;
constexpr int64_t kPlacesPerTask = 64;
constexpr int kLargestRadius = 63;

// A margin of one cell on each side and of one orientation takes the overflow of interpolation.
constexpr int kPaddedCells = kCells + 2, kPaddedOrientations = kOrientations + 1;
using Histogram = std::array<float, kPaddedCells * kPaddedCells * kPaddedOrientations>;

cv::Mat BlurBy(const cv::Mat& image, double sigma) {
  cv::Mat blurred;
  cv::GaussianBlur(image, blurred, cv::Size(), sigma, sigma, cv::BORDER_REFLECT_101);
  return blurred;
}

cv::Mat EverySecondPixel(const cv::Mat& image) {
  cv::Mat half((image.rows + 1) / 2, (image.cols + 1) / 2, image.type());
  for (int y = 0; y < half.rows; ++y) {
    for (int x = 0; x < half.cols; ++x) half.at<float>(y, x) = image.at<float>(2 * y, 2 * x);
  }
  return half;
}

void Gradients(const cv::Mat& image, cv::Mat& magnitude, cv::Mat& angle_bins) {
  const cv::Mat kernel = (cv::Mat_<float>(1, 3) << -1, 0, 1);
  cv::Mat dx, dy;
  cv::filter2D(image, dx, CV_32F, kernel, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  cv::filter2D(image, dy, CV_32F, kernel.t(), cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  cv::cartToPolar(dx, dy, magnitude, angle_bins, /*angleInDegrees=*/true);
  cv::threshold(magnitude, magnitude, kRounding, 0.0, cv::THRESH_TOZERO);
  angle_bins *= kOrientations / 360.0;
}

// Shares `weight` among the eight nearest bins; row and column of the padded histogram, in (0, 5),
// orientation in [0, 8).
inline void Add(float row, float column, float orientation, float weight, Histogram& histogram) {
  const int r = static_cast<int>(row), c = static_cast<int>(column);
  const int o = static_cast<int>(orientation);
  const float fr = row - static_cast<float>(r), fc = column - static_cast<float>(c);
  const float fo = orientation - static_cast<float>(o);
  float* bin = &histogram[(r * kPaddedCells + c) * kPaddedOrientations + o];
  const float lower = weight * (1.0F - fr), upper = weight * fr;
  const float v00 = lower * (1.0F - fc), v01 = lower * fc;
  const float v10 = upper * (1.0F - fc), v11 = upper * fc;
  constexpr int kRow = kPaddedCells * kPaddedOrientations;
  bin[0] += v00 * (1.0F - fo);
  bin[1] += v00 * fo;
  bin[kPaddedOrientations] += v01 * (1.0F - fo);
  bin[kPaddedOrientations + 1] += v01 * fo;
  bin[kRow] += v10 * (1.0F - fo);
  bin[kRow + 1] += v10 * fo;
  bin[kRow + kPaddedOrientations] += v11 * (1.0F - fo);
  bin[kRow + kPaddedOrientations + 1] += v11 * fo;
}

void ToBytes(const Histogram& histogram, uint8_t* out) {
  std::array<float, kSiftDescriptorBytes> h;
  int k = 0;
  for (int r = 1; r <= kCells; ++r) {
    for (int c = 1; c <= kCells; ++c) {
      const float* bin = &histogram[(r * kPaddedCells + c) * kPaddedOrientations];
      for (int o = 0; o < kOrientations; ++o) h[k++] = bin[o];
      h[k - kOrientations] += bin[kOrientations];  // orientation wraps around
    }
  }
  const auto normalize = [&h](float to) {
    float squares = 0.0F;
    for (const float value : h) squares += value * value;
    if (!(squares > 0.0F)) return;
    const float scale = to / std::sqrt(squares);
    for (float& value : h) value *= scale;
  };
  normalize(1.0F);
  for (float& value : h) value = std::min(value, kLargestEntry);
  normalize(kToBytes);
  for (int i = 0; i < kSiftDescriptorBytes; ++i) {
    out[i] = static_cast<uint8_t>(std::min(h[i] + 0.5F, 255.0F));
  }
}

}  // namespace

SiftDescriber::SiftDescriber(const cv::Mat& grey) {
  cv::Mat image;
  grey.convertTo(image, CV_32F);
  image = BlurBy(image, std::sqrt(kFirstSigma * kFirstSigma - kCameraBlur * kCameraBlur));
  const double step = std::exp2(1.0 / kLevelsPerOctave);
  for (float pixels = 1.0F;; pixels *= 2.0F) {
    double sigma = kFirstSigma;
    for (int j = 0; j < kLevelsPerOctave; ++j) {
      Level level;
      Gradients(image, level.magnitude, level.angle_bins);
      level.pixels_per_sample = pixels;
      levels_.push_back(level);
      image = BlurBy(image, sigma * std::sqrt(step * step - 1.0));
      sigma *= step;
    }
    if (std::min(image.rows, image.cols) < 2 * kSmallestSide) break;
    image = EverySecondPixel(image);
  }
}

const SiftDescriber::Level& SiftDescriber::LevelFor(float sigma) const {
  const float exact = kLevelsPerOctave * std::log2(std::max(sigma, kFirstSigma) / kFirstSigma);
  const auto nearest = static_cast<size_t>(exact + 0.5F);
  return levels_[std::min(nearest, levels_.size() - 1)];
}

void SiftDescriber::DescribeOne(const Level& level, const DescribedPlace& place, uint8_t* out) {
  const float cell = kCellWidth * place.sigma / level.pixels_per_sample;  // samples
  const float x = place.position.x / level.pixels_per_sample;
  const float y = place.position.y / level.pixels_per_sample;
  const int centre_x = static_cast<int>(std::lround(x)),
            centre_y = static_cast<int>(std::lround(y));
  // Half the diagonal of the cells and their margin.
  const int radius = std::min(
      static_cast<int>(std::ceil(cell * (kCells + 1) * 0.5F * std::sqrt(2.0F))), kLargestRadius);
  const float radians = place.orientation_degrees * static_cast<float>(CV_PI / 180.0);
  const float cosine = std::cos(radians) / cell, sine = std::sin(radians) / cell;
  float turn = std::fmod(place.orientation_degrees, 360.0F) * (kOrientations / 360.0F);
  if (turn < 0.0F) turn += kOrientations;

  // exp(-(u^2 + v^2) / (2 2^2)) in cells, a product over x and y for every orientation.
  std::array<float, 2 * kLargestRadius + 1> weight_x, weight_y;
  for (int i = -radius; i <= radius; ++i) {
    const float u = (static_cast<float>(centre_x + i) - x) / cell;
    const float v = (static_cast<float>(centre_y + i) - y) / cell;
    weight_x[i + radius] = std::exp(-u * u / 8.0F);
    weight_y[i + radius] = std::exp(-v * v / 8.0F);
  }
  Histogram histogram{};
  const int left = std::max(centre_x - radius, 0);
  const int right = std::min(centre_x + radius, level.magnitude.cols - 1);
  const int top = std::max(centre_y - radius, 0);
  const int bottom = std::min(centre_y + radius, level.magnitude.rows - 1);
  constexpr float kCentre = 0.5F * kCells + 0.5F;  // of the padded histogram
  for (int row = top; row <= bottom; ++row) {
    const float* magnitude = level.magnitude.ptr<float>(row);
    const float* angle = level.angle_bins.ptr<float>(row);
    const float dy = static_cast<float>(row) - y;
    const float wy = weight_y[row - centre_y + radius];
    for (int column = left; column <= right; ++column) {
      const float dx = static_cast<float>(column) - x;
      const float u = dx * cosine + dy * sine + kCentre;
      const float v = dy * cosine - dx * sine + kCentre;
      if (!(u > 0.0F && u < kCells + 1 && v > 0.0F && v < kCells + 1)) continue;
      float orientation = turn - angle[column];
      if (orientation < 0.0F) orientation += kOrientations;
      if (orientation >= kOrientations) orientation -= kOrientations;
      const float weight = magnitude[column] * wy * weight_x[column - centre_x + radius];
      Add(v, u, orientation, weight, histogram);
    }
  }
  ToBytes(histogram, out);
}

void SiftDescriber::Describe(const std::vector<DescribedPlace>& places, int threads,
                             uint8_t* out) const {
  const int64_t count = static_cast<int64_t>(places.size());
  kernels::ParallelFor(
      (count + kPlacesPerTask - 1) / kPlacesPerTask, {.threads = threads}, [&](int64_t task) {
        const int64_t end = std::min((task + 1) * kPlacesPerTask, count);
        for (int64_t i = task * kPlacesPerTask; i < end; ++i) {
          DescribeOne(LevelFor(places[i].sigma), places[i], out + i * kSiftDescriptorBytes);
        }
      });
}

}  // namespace egosieve::vision
