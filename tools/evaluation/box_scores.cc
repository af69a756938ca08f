#include "tools/evaluation/box_scores.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/evaluation/map_sample.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAll = "all";

// In the order of the table.
const std::vector<std::string>& Kinds() {
  static const auto& kinds =
      *new std::vector<std::string>{"moving vehicle",   "moving person",   "moving cyclist",
                                    "standing vehicle", "standing person", "standing cyclist"};
  return kinds;
}

std::string KindOf(const LabelledBox& box) {
  return absl::StrCat(*box.moving ? "moving " : "standing ", BoxClassName(box.box_class));
}

bool Contains(const LabelledBox& box, int x, int y) {
  return x >= box.left && x <= box.right && y >= box.top && y <= box.bottom;
}

}  // namespace

absl::Status BoxScoresOptions::Validate() const {
  if (!(threshold >= 0.0 && threshold <= 1.0) || !(middle > 0.0 && middle <= 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("threshold = %g, middle = %g; they must be from 0 to 1, and middle above 0",
                        threshold, middle));
  }
  return absl::OkStatus();
}

double MeanInMiddle(const LabelledBox& box, const cv::Mat1f& probability,
                    const kernels::ImageGrid& grid, double middle) {
  const double x = 0.5 * (box.left + box.right), y = 0.5 * (box.top + box.bottom);
  const double half_width = 0.5 * middle * (box.right - box.left);
  const double half_height = 0.5 * middle * (box.bottom - box.top);
  const int x0 = std::max(0, static_cast<int>(std::ceil(x - half_width)));
  const int x1 = std::min(grid.width - 1, static_cast<int>(std::floor(x + half_width)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(y - half_height)));
  const int y1 = std::min(grid.height - 1, static_cast<int>(std::floor(y + half_height)));
  double sum = 0.0;
  int64_t count = 0;
  for (int row = y0; row <= y1; ++row) {
    for (int column = x0; column <= x1; ++column) {
      sum += InterpolateAt(probability, grid, column, row);
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : -1.0;
}

void BoxScores::Add(const std::vector<LabelledBox>& boxes, const cv::Mat1f& probability,
                    const kernels::ImageGrid& grid) {
  ++frames_;
  for (const LabelledBox& box : boxes) {
    const double mean = MeanInMiddle(box, probability, grid, options_.middle);
    const bool hidden =
        box.truncated > options_.most_truncated || box.occluded > options_.most_occluded;
    if (hidden || !box.moving || box.box_class == BoxClass::kUntold || !(mean >= 0.0)) {
      ++left_out_;
      continue;
    }
    for (const char* distance : {kAll, box.Distance()}) {
      BoxCount& count = counts_[{KindOf(box), distance}];
      ++count.boxes;
      count.marked += mean >= options_.threshold;
    }
  }
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const int x = grid.x_pixels(column), y = grid.y_pixels(row);
      if (std::any_of(boxes.begin(), boxes.end(),
                      [&](const LabelledBox& box) { return Contains(box, x, y); })) {
        continue;
      }
      ++outside_pixels_;
      outside_marked_ += probability(row, column) >= options_.threshold;
    }
  }
}

void BoxScores::Merge(const BoxScores& other) {
  for (const auto& [group, count] : other.counts_) {
    counts_[group].boxes += count.boxes;
    counts_[group].marked += count.marked;
  }
  frames_ += other.frames_;
  left_out_ += other.left_out_;
  outside_pixels_ += other.outside_pixels_;
  outside_marked_ += other.outside_marked_;
}

BoxCount BoxScores::Of(const std::string& kind, const std::string& distance) const {
  const auto found = counts_.find({kind, distance});
  return found == counts_.end() ? BoxCount{} : found->second;
}

double BoxScores::OutsideShare() const {
  return static_cast<double>(outside_marked_) /
         static_cast<double>(std::max<int64_t>(outside_pixels_, 1));
}

Json BoxScores::ToJson() const {
  Json kinds = Json::object();
  for (const std::string& kind : Kinds()) {
    for (const auto& [group, count] : counts_) {
      if (group.first != kind) continue;
      kinds[kind][group.second] = {{"boxes", count.boxes}, {"marked", count.marked}};
    }
  }
  return {{"threshold", options_.threshold},
          {"frames", frames_},
          {"left_out", left_out_},
          {"kinds", kinds},
          {"outside_pixels", outside_pixels_},
          {"outside_marked_share", OutsideShare()}};
}

std::string BoxScores::ToTable() const {
  std::vector<const char*> distances = {kAll};
  for (const char* distance : kBoxDistances) {
    const auto has = [&](const auto& entry) { return entry.first.second == distance; };
    if (std::any_of(counts_.begin(), counts_.end(), has)) distances.push_back(distance);
  }
  std::string table = absl::StrFormat("%-20s", "boxes marked");
  for (const char* distance : distances) absl::StrAppendFormat(&table, " %15s", distance);
  table.push_back('\n');
  for (const std::string& kind : Kinds()) {
    if (Of(kind, kAll).boxes == 0) continue;
    absl::StrAppendFormat(&table, "%-20s", kind);
    for (const char* distance : distances) {
      const BoxCount count = Of(kind, distance);
      const std::string cell = count.boxes == 0
                                   ? "-"
                                   : absl::StrFormat("%d of %d %.2f", count.marked, count.boxes,
                                                     static_cast<double>(count.marked) /
                                                         static_cast<double>(count.boxes));
      absl::StrAppendFormat(&table, " %15s", cell);
    }
    table.push_back('\n');
  }
  absl::StrAppendFormat(&table,
                        "%d boxes left out (largely hidden, or class or motion unknown); outside "
                        "all boxes %.4f is marked; %d frames\n",
                        left_out_, OutsideShare(), frames_);
  return table;
}

}  // namespace egosieve::tools
