#include "tools/evaluation/temporal_stability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace egosieve::tools {
namespace {

constexpr double kTolerancePixels = 3.0;
constexpr double kSpacingPixels = 3.0;
constexpr int kDirections = 12, kRings = 5;
constexpr double kInnerRadius = 0.125, kOuterRadius = 2.0;  // mean distances

std::vector<cv::Point2d> SampleContour(const cv::Mat1b& mask) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask != 0, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  if (contours.empty()) return {};
  const auto longest =
      std::max_element(contours.begin(), contours.end(),
                       [](const auto& a, const auto& b) { return a.size() < b.size(); });
  std::vector<cv::Point> polygon;
  cv::approxPolyDP(*longest, polygon, kTolerancePixels, true);
  std::vector<cv::Point2d> points;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const cv::Point2d from = polygon[i], to = polygon[(i + 1) % polygon.size()];
    const int pieces =
        std::max(1, static_cast<int>(std::ceil(cv::norm(to - from) / kSpacingPixels)));
    for (int k = 0; k < pieces; ++k) points.push_back(from + (to - from) * (1.0 * k / pieces));
  }
  return points;
}

float Difference(const ShapeContext& a, const ShapeContext& b) {
  float sum = 0.0f;
  for (size_t i = 0; i < a.size(); ++i) {
    const float difference = a[i] - b[i];
    sum += difference * difference / (a[i] + b[i] + 1e-20f);
  }
  return 0.5f * sum;
}

struct Pair {
  int before = 0, now = 0;
};

// The path of least cost from the first pair to the last; point i of a contour means point i +
// start.
std::vector<Pair> LeastPath(const cv::Mat1f& cost, Pair start) {
  const int rows = cost.rows, columns = cost.cols;
  const auto at = [&](int i, int j) {
    return cost((i + start.before) % rows, (j + start.now) % columns);
  };
  cv::Mat1d total(rows, columns, std::numeric_limits<double>::infinity());
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      double best = i == 0 && j == 0 ? 0.0 : std::numeric_limits<double>::infinity();
      if (i > 0) best = std::min(best, total(i - 1, j));
      if (j > 0) best = std::min(best, total(i, j - 1));
      if (i > 0 && j > 0) best = std::min(best, total(i - 1, j - 1));
      total(i, j) = best + at(i, j);
    }
  }
  std::vector<Pair> path;
  for (int i = rows - 1, j = columns - 1;;) {
    path.push_back({(i + start.before) % rows, (j + start.now) % columns});
    if (i == 0 && j == 0) break;
    const double diagonal =
        i > 0 && j > 0 ? total(i - 1, j - 1) : std::numeric_limits<double>::infinity();
    const double up = i > 0 ? total(i - 1, j) : std::numeric_limits<double>::infinity();
    const double left = j > 0 ? total(i, j - 1) : std::numeric_limits<double>::infinity();
    if (diagonal <= up && diagonal <= left) {
      --i, --j;
    } else if (up <= left) {
      --i;
    } else {
      --j;
    }
  }
  return path;
}

// Of the pairs with the same `point`, keeps the cheapest.
std::vector<Pair> KeepBest(const std::vector<Pair>& pairs, const cv::Mat1f& cost, int Pair::*point,
                           int points) {
  std::vector<int> best(points, -1);
  for (size_t i = 0; i < pairs.size(); ++i) {
    int& kept = best[pairs[i].*point];
    if (kept < 0 || cost(pairs[i].before, pairs[i].now) < cost(pairs[kept].before, pairs[kept].now))
      kept = static_cast<int>(i);
  }
  std::vector<Pair> result;
  for (const int kept : best) {
    if (kept >= 0) result.push_back(pairs[kept]);
  }
  return result;
}

}  // namespace

std::vector<ShapeContext> DescribeOutline(const cv::Mat1b& mask) {
  const std::vector<cv::Point2d> points = SampleContour(mask);
  const auto count = static_cast<double>(points.size());
  double mean = 0.0;
  for (const cv::Point2d& a : points) {
    for (const cv::Point2d& b : points) mean += cv::norm(a - b) / (count * count);
  }
  std::array<double, kRings> edges;
  for (int k = 0; k < kRings; ++k) {
    edges[k] = mean * kInnerRadius *
               std::pow(kOuterRadius / kInnerRadius, static_cast<double>(k) / (kRings - 1));
  }
  std::vector<ShapeContext> contexts;
  for (const cv::Point2d& from : points) {
    ShapeContext context = {};
    float inside = 0.0f;
    for (const cv::Point2d& to : points) {
      const cv::Point2d offset = to - from;
      const auto ring = std::upper_bound(edges.begin(), edges.end(), cv::norm(offset));
      if (ring == edges.end()) continue;
      double angle = std::atan2(offset.y, offset.x) / (2.0 * std::numbers::pi);
      angle -= std::floor(angle);
      const int direction = std::min(static_cast<int>(angle * kDirections), kDirections - 1);
      ++context[direction * kRings + (ring - edges.begin())];
      ++inside;
    }
    for (float& share : context) share /= std::max(inside, 1.0f);
    contexts.push_back(context);
  }
  return contexts;
}

std::optional<double> OutlineChange(const std::vector<ShapeContext>& before,
                                    const std::vector<ShapeContext>& now) {
  if (before.empty() || now.empty()) return std::nullopt;
  cv::Mat1f cost(static_cast<int>(before.size()), static_cast<int>(now.size()));
  for (int i = 0; i < cost.rows; ++i) {
    for (int j = 0; j < cost.cols; ++j) cost(i, j) = Difference(before[i], now[j]);
  }
  const auto cost_of = [&](const Pair& pair) { return cost(pair.before, pair.now); };
  const std::vector<Pair> first = LeastPath(cost, {});
  const Pair start =
      *std::min_element(first.begin(), first.end(),
                        [&](const Pair& a, const Pair& b) { return cost_of(a) < cost_of(b); });
  std::vector<Pair> pairs = LeastPath(cost, start);
  pairs = KeepBest(pairs, cost, &Pair::before, cost.rows);
  pairs = KeepBest(pairs, cost, &Pair::now, cost.cols);
  double sum = 0.0;
  for (const Pair& pair : pairs) sum += cost_of(pair);
  return sum / static_cast<double>(pairs.size());
}

}  // namespace egosieve::tools
