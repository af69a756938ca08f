#include "tools/evaluation/track_truth.h"

#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

enum Field { kTrack, kLabel, kFrame, kX, kY, kFieldCount };
constexpr const char* kFields[] = {"track", "label", "frame", "x", "y"};

using Columns = std::vector<absl::string_view>;

Columns Split(absl::string_view line) {
  Columns columns = absl::StrSplit(line, ',');
  for (absl::string_view& column : columns) column = absl::StripAsciiWhitespace(column);
  return columns;
}

// Where each field stands.
absl::StatusOr<std::vector<size_t>> ReadHeader(absl::string_view line) {
  const Columns columns = Split(line);
  std::vector<size_t> places;
  for (const char* field : kFields) {
    size_t place = 0;
    while (place < columns.size() && columns[place] != field) ++place;
    if (place == columns.size()) {
      return absl::DataLossError(
          absl::StrCat("line 1 has no field \"", field, "\"; it must be: track,label,frame,x,y"));
    }
    places.push_back(place);
  }
  return places;
}

absl::Status BadLine(int64_t number, absl::string_view why) {
  return absl::DataLossError(absl::StrCat("line ", number, ": ", why));
}

absl::Status ReadPoint(absl::string_view line, int64_t number, const std::vector<size_t>& places,
                       TrackTruth* truth) {
  const Columns columns = Split(line);
  absl::string_view text[kFieldCount];
  for (int field = 0; field < kFieldCount; ++field) {
    if (places[field] >= columns.size())
      return BadLine(number, absl::StrCat("no ", kFields[field]));
    text[field] = columns[places[field]];
  }
  LabelledPoint point;
  int64_t frame = 0;
  if (!absl::SimpleAtoi(text[kTrack], &point.track)) return BadLine(number, "track is no integer");
  if (!absl::SimpleAtoi(text[kLabel], &point.label) || point.label < 1)
    return BadLine(number, "label is no integer from 1");
  if (!absl::SimpleAtoi(text[kFrame], &frame) || frame < 0)
    return BadLine(number, "frame is no integer from 0");
  if (!absl::SimpleAtod(text[kX], &point.x) || !std::isfinite(point.x))
    return BadLine(number, "x is no number");
  if (!absl::SimpleAtod(text[kY], &point.y) || !std::isfinite(point.y))
    return BadLine(number, "y is no number");
  ++(point.dynamic() ? truth->dynamic_points : truth->static_points);
  truth->frames[frame].push_back(point);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TrackTruth> ParseTrackTruth(absl::string_view csv) {
  TrackTruth truth;
  std::vector<size_t> places;
  int64_t number = 0;
  for (absl::string_view line : absl::StrSplit(csv, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line);
    if (number == 1) {
      EGOSIEVE_ASSIGN_OR_RETURN(places, ReadHeader(line));
    } else if (!line.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(ReadPoint(line, number, places, &truth));
    }
  }
  if (truth.static_points == 0 || truth.dynamic_points == 0) {
    return absl::FailedPreconditionError(absl::StrCat(truth.static_points, " static and ",
                                                      truth.dynamic_points,
                                                      " dynamic points; both are needed"));
  }
  return truth;
}

absl::StatusOr<TrackTruth> ReadTrackTruth(const std::string& path) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  absl::StatusOr<TrackTruth> truth = ParseTrackTruth(text);
  if (!truth.ok()) {
    return absl::Status(truth.status().code(), absl::StrCat(path, ": ", truth.status().message()));
  }
  return truth;
}

}  // namespace egosieve::tools
