#include "tools/run_folder/frame_record.h"

#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using Outcome = FrameRecord::Outcome;

Json PointsToJson(const FrameRecord::PointCounts& points) {
  return Json{{"offered", points.offered},
              {"added", points.added},
              {"dropped_density", points.dropped_density},
              {"dropped_novelty", points.dropped_novelty},
              {"dropped_consistency", points.dropped_consistency},
              {"dropped_model_density", points.dropped_model_density},
              {"dropped_budget", points.dropped_budget}};
}

absl::Status ReadPoints(const Json& json, FrameRecord::PointCounts& points) {
  JsonFields fields(json, "points");
  fields.Read("offered", points.offered);
  fields.Read("added", points.added);
  fields.Read("dropped_density", points.dropped_density);
  fields.Read("dropped_novelty", points.dropped_novelty);
  fields.Read("dropped_consistency", points.dropped_consistency);
  fields.Read("dropped_model_density", points.dropped_model_density);
  fields.Read("dropped_budget", points.dropped_budget);
  return fields.status();
}

absl::Status ReadOutcome(const std::string& name, Outcome& outcome) {
  for (const Outcome candidate : {Outcome::kLearnt, Outcome::kAnswered, Outcome::kFailed}) {
    if (name == OutcomeName(candidate)) {
      outcome = candidate;
      return absl::OkStatus();
    }
  }
  return absl::DataLossError(absl::StrCat("unknown outcome '", name, "'"));
}

absl::Status ReadMilliseconds(const Json& json,
                              std::vector<std::pair<std::string, double>>& milliseconds) {
  for (const auto& [stage, value] : json.items()) {
    if (!value.is_number()) {
      return absl::DataLossError(absl::StrCat("milliseconds of '", stage, "' are not a number"));
    }
    milliseconds.emplace_back(stage, value.get<double>());
  }
  return absl::OkStatus();
}

}  // namespace

const char* OutcomeName(Outcome outcome) {
  switch (outcome) {
    case Outcome::kLearnt:
      return "learnt";
    case Outcome::kAnswered:
      return "answered";
    case Outcome::kFailed:
      return "failed";
  }
  return "";
}

Json ToJson(const FrameRecord& record) {
  Json milliseconds = Json::object();
  for (const auto& [stage, value] : record.milliseconds) {
    milliseconds[stage] = value;
  }
  return Json{{"index", record.index},
              {"time_seconds", record.time_seconds},
              {"outcome", OutcomeName(record.outcome)},
              {"reason", record.reason.empty() ? Json() : Json(record.reason)},
              {"matches", record.matches},
              {"motion_model", record.motion_model},
              {"inliers", record.inliers},
              {"labelled_static", record.labelled_static},
              {"labelled_dynamic", record.labelled_dynamic},
              {"points", PointsToJson(record.points)},
              {"model_size", record.model_size},
              {"theta", record.theta},
              {"a", record.a},
              {"b", record.b},
              {"log_likelihood", record.log_likelihood},
              {"dynamic_share", record.dynamic_share},
              {"clamped_variances", record.clamped_variances},
              {"saturated_deviations", record.saturated_deviations},
              {"milliseconds", milliseconds}};
}

absl::StatusOr<FrameRecord> FrameRecordFromJson(const Json& json) {
  FrameRecord record;
  JsonFields fields(json, "the frame's line");
  std::string outcome;
  Json reason;
  fields.Read("index", record.index);
  fields.Read("time_seconds", record.time_seconds);
  fields.Read("outcome", outcome);
  fields.Keep(ReadOutcome(outcome, record.outcome));
  fields.Read("reason", reason);
  fields.Read("matches", record.matches);
  fields.Read("motion_model", record.motion_model);
  fields.Read("inliers", record.inliers);
  fields.Read("labelled_static", record.labelled_static);
  fields.Read("labelled_dynamic", record.labelled_dynamic);
  fields.Keep(ReadPoints(fields.Object("points"), record.points));
  fields.Read("model_size", record.model_size);
  fields.Read("theta", record.theta);
  fields.Read("a", record.a);
  fields.Read("b", record.b);
  fields.Read("log_likelihood", record.log_likelihood);
  fields.Read("dynamic_share", record.dynamic_share);
  fields.Read("clamped_variances", record.clamped_variances);
  fields.Read("saturated_deviations", record.saturated_deviations);
  fields.Keep(ReadMilliseconds(fields.Object("milliseconds"), record.milliseconds));
  if (reason.is_string()) {
    record.reason = reason.get<std::string>();
  }
  if (!fields.status().ok()) {
    return fields.status();
  }
  return record;
}

std::string ToLine(const FrameRecord& record) {
  // A file name in a reason may hold bytes that are not UTF-8.
  return ToJson(record).dump(-1, ' ', false, Json::error_handler_t::replace);
}

absl::StatusOr<FrameRecord> FrameRecordFromLine(absl::string_view line) {
  const Json json = Json::parse(line.begin(), line.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    return absl::DataLossError("the line is not JSON");
  }
  return FrameRecordFromJson(json);
}

}  // namespace egosieve::tools
