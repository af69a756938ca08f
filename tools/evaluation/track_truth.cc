#include "tools/evaluation/track_truth.h"

#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/csv_table.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

enum Field { kTrack, kLabel, kFrame, kX, kY };

absl::Status ReadPoint(const CsvRow& row, TrackTruth* truth) {
  LabelledPoint point;
  int64_t frame = 0;
  if (!absl::SimpleAtoi(row.texts[kTrack], &point.track)) return row.Bad("track is no integer");
  if (!absl::SimpleAtoi(row.texts[kLabel], &point.label) || point.label < 1)
    return row.Bad("label is no integer from 1");
  if (!absl::SimpleAtoi(row.texts[kFrame], &frame) || frame < 0)
    return row.Bad("frame is no integer from 0");
  if (!absl::SimpleAtod(row.texts[kX], &point.x) || !std::isfinite(point.x))
    return row.Bad("x is no number");
  if (!absl::SimpleAtod(row.texts[kY], &point.y) || !std::isfinite(point.y))
    return row.Bad("y is no number");
  ++(point.dynamic() ? truth->dynamic_points : truth->static_points);
  truth->frames[frame].push_back(point);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TrackTruth> ParseTrackTruth(absl::string_view csv) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<CsvRow> rows,
                            ParseCsv(csv, {"track", "label", "frame", "x", "y"}));
  TrackTruth truth;
  for (const CsvRow& row : rows) EGOSIEVE_RETURN_IF_ERROR(ReadPoint(row, &truth));
  if (truth.static_points == 0 || truth.dynamic_points == 0) {
    return absl::FailedPreconditionError(absl::StrCat(truth.static_points, " static and ",
                                                      truth.dynamic_points,
                                                      " dynamic points; both are needed"));
  }
  return truth;
}

absl::StatusOr<TrackTruth> ReadTrackTruth(const std::string& path) {
  return ParseFile(path, ParseTrackTruth);
}

}  // namespace egosieve::tools
