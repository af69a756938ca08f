#include "tools/evaluation/box_truth.h"

#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/csv_table.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

enum Field {
  kFrame,
  kId,
  kType,
  kX1,
  kY1,
  kX2,
  kY2,
  kMoving,
  kTruncated,
  kOccluded,
  kDepth,
  kRange
};
const char* const kNames[] = {"frame", "id",     "type",      "x1",       "y1",    "x2",
                              "y2",    "moving", "truncated", "occluded", "depth", "range"};

BoxClass ClassOf(const std::string& type) {
  static const auto& classes = *new std::map<std::string, BoxClass>{
      {"Car", BoxClass::kVehicle},     {"Van", BoxClass::kVehicle},
      {"Truck", BoxClass::kVehicle},   {"Tram", BoxClass::kVehicle},
      {"Bus", BoxClass::kVehicle},     {"Pedestrian", BoxClass::kPerson},
      {"Person", BoxClass::kPerson},   {"Person_sitting", BoxClass::kPerson},
      {"Cyclist", BoxClass::kCyclist},
  };
  const auto found = classes.find(type);
  return found == classes.end() ? BoxClass::kUntold : found->second;
}

absl::StatusOr<double> NumberIn(const CsvRow& row, Field field) {
  double value = 0.0;
  if (!absl::SimpleAtod(row.texts[field], &value) || !std::isfinite(value)) {
    return row.Bad(absl::StrCat(kNames[field], " is no number"));
  }
  return value;
}

// An empty field leaves `level` unchanged.
absl::Status ReadLevel(const CsvRow& row, Field field, int* level) {
  if (row.texts[field].empty()) return absl::OkStatus();
  if (absl::SimpleAtoi(row.texts[field], level)) return absl::OkStatus();
  return row.Bad(absl::StrCat(kNames[field], " is no integer"));
}

absl::Status ReadBox(const CsvRow& row, BoxTruth* truth) {
  int64_t frame = 0;
  LabelledBox box;
  if (!absl::SimpleAtoi(row.texts[kFrame], &frame) || frame < 0)
    return row.Bad("frame is no integer from 0");
  if (!absl::SimpleAtoi(row.texts[kId], &box.id)) return row.Bad("id is no integer");
  box.box_class = ClassOf(row.texts[kType]);
  EGOSIEVE_ASSIGN_OR_RETURN(box.left, NumberIn(row, kX1));
  EGOSIEVE_ASSIGN_OR_RETURN(box.top, NumberIn(row, kY1));
  EGOSIEVE_ASSIGN_OR_RETURN(box.right, NumberIn(row, kX2));
  EGOSIEVE_ASSIGN_OR_RETURN(box.bottom, NumberIn(row, kY2));
  if (!(box.right > box.left && box.bottom > box.top)) return row.Bad("the box has no area");
  const std::string& moving = row.texts[kMoving];
  if (moving != "" && moving != "0" && moving != "1") return row.Bad("moving is not 0, 1 or empty");
  if (!moving.empty()) box.moving = moving == "1";
  EGOSIEVE_RETURN_IF_ERROR(ReadLevel(row, kTruncated, &box.truncated));
  EGOSIEVE_RETURN_IF_ERROR(ReadLevel(row, kOccluded, &box.occluded));
  if (!row.texts[kDepth].empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(box.depth_metres, NumberIn(row, kDepth));
  }
  box.range = row.texts[kRange];
  if (box.range != "" && box.range != "near" && box.range != "far")
    return row.Bad("range is not near, far or empty");
  (*truth)[frame].push_back(std::move(box));
  return absl::OkStatus();
}

}  // namespace

const char* BoxClassName(BoxClass box_class) {
  switch (box_class) {
    case BoxClass::kVehicle:
      return "vehicle";
    case BoxClass::kPerson:
      return "person";
    case BoxClass::kCyclist:
      return "cyclist";
    case BoxClass::kUntold:
      return "untold";
  }
  return "";
}

const char* LabelledBox::Distance() const {
  if (depth_metres) {
    return *depth_metres < 10.0   ? "0-10 m"
           : *depth_metres < 20.0 ? "10-20 m"
           : *depth_metres < 40.0 ? "20-40 m"
                                  : "40+ m";
  }
  return range == "near" ? "near" : range == "far" ? "far" : "unknown";
}

absl::StatusOr<BoxTruth> ParseBoxTruth(absl::string_view csv) {
  const std::vector<std::string> required(kNames, kNames + kTruncated);
  const std::vector<std::string> optional(kNames + kTruncated, std::end(kNames));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<CsvRow> rows, ParseCsv(csv, required, optional));
  BoxTruth truth;
  for (const CsvRow& row : rows) EGOSIEVE_RETURN_IF_ERROR(ReadBox(row, &truth));
  return truth;
}

absl::StatusOr<BoxTruth> ReadBoxTruth(const std::string& path) {
  return ParseFile(path, ParseBoxTruth);
}

}  // namespace egosieve::tools
