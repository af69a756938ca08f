#include "vision/masks/motion_split.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace egosieve::vision {
namespace {

using Affine = Eigen::Matrix<double, 3, 2>;

// Residuals beyond the scale weigh little: at least this many pixels, and a part of the median of
// those to a single motion, since flow errs more where it is large.
constexpr double kLeastScale = 0.5;
constexpr double kScaleShare = 0.25;
constexpr int kFitRounds = 4, kSplitRounds = 8;

struct Cell {
  int column = 0, row = 0;
  Eigen::RowVector3d place;  // (1, x, y), about [-1, 1]
  Eigen::RowVector2d flow;
};

double Residual(const Cell& cell, const Affine& motion) {
  return (cell.flow - cell.place * motion).norm();
}

double Rho(double residual, double scale) {
  const double square = residual * residual;
  return square / (square + scale * scale);
}

std::vector<Cell> MakeCells(const cv::Mat1b& region, const cv::Mat& flow, int side) {
  std::vector<Cell> cells;
  const double scale = 2.0 / std::max(region.cols, region.rows);
  for (int row = 0; row * side + side <= region.rows; ++row) {
    for (int column = 0; column * side + side <= region.cols; ++column) {
      const cv::Rect block(column * side, row * side, side, side);
      if (2 * cv::countNonZero(region(block)) <= side * side) continue;
      const cv::Scalar mean = cv::mean(flow(block), region(block));
      Cell cell{column, row, {}, {mean[0], mean[1]}};
      cell.place << 1.0, scale * (block.x + 0.5 * side) - 1.0, scale * (block.y + 0.5 * side) - 1.0;
      cells.push_back(cell);
    }
  }
  return cells;
}

// (S1) over the cells with that label, by iterated weights.
Affine Fit(const std::vector<Cell>& cells, const std::vector<int>& labels, int label,
           double scale) {
  Affine motion = Affine::Zero();
  for (int round = 0; round < kFitRounds; ++round) {
    Eigen::Matrix3d normal = 1e-6 * Eigen::Matrix3d::Identity();
    Affine right = Affine::Zero();
    for (size_t i = 0; i < cells.size(); ++i) {
      if (labels[i] != label) continue;
      const double r = round == 0 ? 0.0 : Residual(cells[i], motion) / scale;
      const double weight = 1.0 / ((1.0 + r * r) * (1.0 + r * r));
      normal += weight * cells[i].place.transpose() * cells[i].place;
      right += weight * cells[i].place.transpose() * cells[i].flow;
    }
    motion = normal.ldlt().solve(right);
  }
  return motion;
}

double Cost(const std::vector<Cell>& cells, const std::vector<int>& labels,
            const std::array<Affine, 2>& motions, double scale) {
  double sum = 0.0;
  for (size_t i = 0; i < cells.size(); ++i) {
    sum += Rho(Residual(cells[i], motions[labels[i]]), scale);
  }
  return sum;
}

// Each cell to the motion with the smaller cost over the 3 x 3 cells around it.
std::vector<int> Assign(const std::vector<Cell>& cells, const cv::Mat1i& number,
                        const std::array<Affine, 2>& motions, double scale) {
  std::vector<int> labels(cells.size());
  for (size_t i = 0; i < cells.size(); ++i) {
    double lead = 0.0;
    for (int row = cells[i].row - 1; row <= cells[i].row + 1; ++row) {
      for (int column = cells[i].column - 1; column <= cells[i].column + 1; ++column) {
        if (row < 0 || column < 0 || row >= number.rows || column >= number.cols) continue;
        const int other = number(row, column);
        if (other < 0) continue;
        lead += Rho(Residual(cells[other], motions[0]), scale) -
                Rho(Residual(cells[other], motions[1]), scale);
      }
    }
    labels[i] = lead > 0.0 ? 1 : 0;
  }
  return labels;
}

struct Split {
  std::vector<int> labels;
  std::array<Affine, 2> motions;
  double cost = 0.0;
};

// From the halves along a direction of `value`.
template <typename Value>
Split SplitFrom(const std::vector<Cell>& cells, const cv::Mat1i& number, double scale,
                Value value) {
  std::vector<double> values;
  for (const Cell& cell : cells) values.push_back(value(cell));
  std::vector<double> sorted = values;
  const auto middle = sorted.begin() + static_cast<int64_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  Split split;
  for (const double v : values) split.labels.push_back(v < *middle ? 0 : 1);
  for (int round = 0; round < kSplitRounds; ++round) {
    split.motions = {Fit(cells, split.labels, 0, scale), Fit(cells, split.labels, 1, scale)};
    split.labels = Assign(cells, number, split.motions, scale);
  }
  split.cost = Cost(cells, split.labels, split.motions, scale);
  return split;
}

// Whether the cells with that label are mostly connected.
bool IsOnePiece(const std::vector<Cell>& cells, const std::vector<int>& labels, int label,
                cv::Size grid) {
  cv::Mat1b part = cv::Mat1b::zeros(grid);
  int count = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    if (labels[i] != label) continue;
    part(cells[i].row, cells[i].column) = 255;
    ++count;
  }
  cv::Mat pieces, stats, centres;
  const int pieces_count = cv::connectedComponentsWithStats(part, pieces, stats, centres, 8);
  int largest = 0;
  for (int i = 1; i < pieces_count; ++i) {
    largest = std::max(largest, stats.at<int>(i, cv::CC_STAT_AREA));
  }
  return 10 * largest >= 7 * count;
}

bool IsAccepted(const std::vector<Cell>& cells, const Split& split, double cost_of_one,
                cv::Size grid, const MotionSplitOptions& options) {
  const auto second = std::count(split.labels.begin(), split.labels.end(), 1);
  const auto all = static_cast<int64_t>(cells.size());
  const auto smaller = static_cast<double>(std::min<int64_t>(second, all - second));
  if (smaller < options.min_share * static_cast<double>(all)) return false;
  if (!(split.cost < options.gain * cost_of_one)) return false;
  double difference = 0.0;
  for (const Cell& cell : cells) {
    difference += (cell.place * (split.motions[0] - split.motions[1])).norm();
  }
  if (difference < options.min_pixels * static_cast<double>(all)) return false;
  return IsOnePiece(cells, split.labels, 0, grid) && IsOnePiece(cells, split.labels, 1, grid);
}

}  // namespace

cv::Mat1b SplitByMotion(const cv::Mat1b& region, const cv::Mat& flow,
                        const MotionSplitOptions& options) {
  const std::vector<Cell> cells = MakeCells(region, flow, options.cell_pixels);
  if (static_cast<int>(cells.size()) < options.min_cells) return {};
  const std::vector<int> together(cells.size(), 0);
  const Affine one = Fit(cells, together, 0, kLeastScale);
  std::vector<double> residuals;
  for (const Cell& cell : cells) residuals.push_back(Residual(cell, one));
  const auto middle = residuals.begin() + static_cast<int64_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  const double scale = std::max(kLeastScale, kScaleShare * *middle);
  const double cost_of_one = Cost(cells, together, {one, one}, scale);
  // Where one motion explains nearly all, there is nothing to win.
  if (cost_of_one < 0.1 * static_cast<double>(cells.size())) return {};
  const cv::Size grid(region.cols / options.cell_pixels, region.rows / options.cell_pixels);
  cv::Mat1i number(grid, -1);
  for (size_t i = 0; i < cells.size(); ++i) {
    number(cells[i].row, cells[i].column) = static_cast<int>(i);
  }
  Split best = SplitFrom(cells, number, scale, [](const Cell& cell) { return cell.place[1]; });
  const auto consider = [&](Split split) {
    if (split.cost < best.cost) best = std::move(split);
  };
  consider(SplitFrom(cells, number, scale, [](const Cell& cell) { return cell.place[2]; }));
  consider(SplitFrom(cells, number, scale, [](const Cell& cell) { return cell.flow[0]; }));
  consider(SplitFrom(cells, number, scale, [](const Cell& cell) { return cell.flow[1]; }));
  if (!IsAccepted(cells, best, cost_of_one, grid, options)) return {};
  const bool second_is_larger = 2 * std::count(best.labels.begin(), best.labels.end(), 1) >
                                static_cast<int64_t>(cells.size());
  // Every pixel goes with the cell nearest to it.
  std::array<cv::Mat1f, 2> distances;
  for (const int part : {0, 1}) {
    cv::Mat1b is_elsewhere(region.size(), uint8_t{255});
    for (size_t i = 0; i < cells.size(); ++i) {
      if (best.labels[i] != part) continue;
      const int side = options.cell_pixels;
      is_elsewhere(cv::Rect(cells[i].column * side, cells[i].row * side, side, side)) = 0;
    }
    cv::distanceTransform(is_elsewhere, distances[part], cv::DIST_L2, cv::DIST_MASK_5);
  }
  cv::Mat1b parts = cv::Mat1b::zeros(region.size());
  parts.setTo(second_is_larger ? 2 : 1, region);
  parts.setTo(second_is_larger ? 1 : 2, (distances[1] < distances[0]) & (region != 0));
  return parts;
}

}  // namespace egosieve::vision
