#include "tools/run_folder/frame_line.h"

#include <Eigen/Core>
#include <array>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "tools/run_folder/json_fields.h"
#include "tools/run_folder/json_name.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using Outcome = FrameLine::Outcome;

Json PointsToJson(const vision::SelectionCounts& points) {
  return Json{{"candidates", points.candidates},
              {"dropped_by_density", points.dropped_by_density},
              {"dropped_by_novelty", points.dropped_by_novelty},
              {"added", points.added},
              {"dropped_by_consistency", points.dropped_by_consistency},
              {"dropped_by_model_density", points.dropped_by_model_density},
              {"dropped_by_age", points.dropped_by_age},
              {"dropped_by_budget", points.dropped_by_budget}};
}

absl::Status ReadPoints(const Json& json, vision::SelectionCounts& points) {
  JsonFields fields(json, "points");
  fields.Read("candidates", points.candidates);
  fields.Read("dropped_by_density", points.dropped_by_density);
  fields.Read("dropped_by_novelty", points.dropped_by_novelty);
  fields.Read("added", points.added);
  fields.Read("dropped_by_consistency", points.dropped_by_consistency);
  fields.Read("dropped_by_model_density", points.dropped_by_model_density);
  fields.Read("dropped_by_age", points.dropped_by_age);
  fields.Read("dropped_by_budget", points.dropped_by_budget);
  return fields.status();
}

// null if not known.
Json StepToJson(const vision::CameraStep& step) {
  if (!step.known) return Json();
  const auto list = [](const Eigen::Vector3d& v) { return Json{v(0), v(1), v(2)}; };
  return Json{{"rotation", list(step.rotation)},
              {"direction", list(step.direction)},
              {"onward", step.onward},
              {"heights", step.heights}};
}

absl::Status ReadStep(const Json& json, vision::CameraStep& step) {
  if (json.is_null()) return absl::OkStatus();
  JsonFields fields(json, "step");
  std::array<double, 3> rotation{}, direction{};
  fields.Read("rotation", rotation);
  fields.Read("direction", direction);
  fields.Read("onward", step.onward);
  fields.Read("heights", step.heights);
  step.known = true;
  step.rotation = Eigen::Vector3d(rotation.data());
  step.direction = Eigen::Vector3d(direction.data());
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

absl::Status ReadNumbers(const Json& json, const char* field,
                         std::vector<std::pair<std::string, double>>& numbers) {
  for (const auto& [name, value] : json.items()) {
    if (!value.is_number()) {
      return absl::DataLossError(absl::StrCat(field, " of '", name, "' are not a number"));
    }
    numbers.emplace_back(name, value.get<double>());
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

Json ToJson(const FrameLine& line) {
  Json milliseconds = Json::object();
  for (const auto& [stage, value] : line.milliseconds) {
    milliseconds[stage] = value;
  }
  Json decided_by = Json::object();
  for (const auto& [term, share] : line.decided_by) {
    decided_by[term] = share;
  }
  Json json{{"index", line.index},
            {"image", JsonName(line.image)},
            {"time_seconds", line.time_seconds},
            {"outcome", OutcomeName(line.outcome)},
            {"reason", line.reason.empty() ? Json() : Json(line.reason)},
            {"doubt", line.doubt.empty() ? Json() : Json(line.doubt)},
            {"width_pixels", line.width_pixels},
            {"height_pixels", line.height_pixels},
            {"features", line.features},
            {"matches", line.matches},
            {"motion_model", line.motion_model},
            {"inliers", line.inliers},
            {"noise_pixels", line.noise_pixels},
            {"labelled_static", line.labelled_static},
            {"labelled_dynamic", line.labelled_dynamic},
            {"frame_gap", line.frame_gap},
            {"decided_by", decided_by},
            {"step", StepToJson(line.step)},
            {"points", PointsToJson(line.points)},
            {"model_size", line.model_size},
            {"theta", line.theta},
            {"a", line.a},
            {"b", line.b},
            {"log_likelihood_per_point", line.log_likelihood_per_point},
            {"factor_rebuilt", line.factor_rebuilt},
            {"jitter", line.jitter},
            {"dynamic_share", line.dynamic_share},
            {"expected_overlap", line.expected_overlap},
            {"clamped_variances", line.clamped_variances},
            {"saturated_deviations", line.saturated_deviations}};
  if (!line.map_device.empty()) json["map_device"] = line.map_device;
  json["milliseconds"] = milliseconds;
  return json;
}

absl::StatusOr<FrameLine> FrameLineFromJson(const Json& json) {
  FrameLine line;
  JsonFields fields(json, "the frame's line");
  std::string outcome;
  Json reason, doubt, step;
  fields.Read("index", line.index);
  fields.ReadIfThere("image", line.image);
  fields.Read("time_seconds", line.time_seconds);
  fields.Read("outcome", outcome);
  fields.Keep(ReadOutcome(outcome, line.outcome));
  fields.Read("reason", reason);
  fields.ReadIfThere("doubt", doubt);
  fields.Read("width_pixels", line.width_pixels);
  fields.Read("height_pixels", line.height_pixels);
  fields.Read("features", line.features);
  fields.Read("matches", line.matches);
  fields.Read("motion_model", line.motion_model);
  fields.Read("inliers", line.inliers);
  fields.Read("noise_pixels", line.noise_pixels);
  fields.Read("labelled_static", line.labelled_static);
  fields.Read("labelled_dynamic", line.labelled_dynamic);
  fields.Read("frame_gap", line.frame_gap);
  fields.Keep(ReadNumbers(fields.Object("decided_by"), "decided_by", line.decided_by));
  fields.ReadIfThere("step", step);
  fields.Keep(ReadStep(step, line.step));
  fields.Keep(ReadPoints(fields.Object("points"), line.points));
  fields.Read("model_size", line.model_size);
  fields.Read("theta", line.theta);
  fields.Read("a", line.a);
  fields.Read("b", line.b);
  fields.Read("log_likelihood_per_point", line.log_likelihood_per_point);
  fields.Read("factor_rebuilt", line.factor_rebuilt);
  fields.Read("jitter", line.jitter);
  fields.Read("dynamic_share", line.dynamic_share);
  fields.ReadIfThere("expected_overlap", line.expected_overlap);
  fields.Read("clamped_variances", line.clamped_variances);
  fields.Read("saturated_deviations", line.saturated_deviations);
  fields.ReadIfThere("map_device", line.map_device);
  fields.Keep(ReadNumbers(fields.Object("milliseconds"), "milliseconds", line.milliseconds));
  if (reason.is_string()) {
    line.reason = reason.get<std::string>();
  }
  if (doubt.is_string()) line.doubt = doubt.get<std::string>();
  if (!fields.status().ok()) {
    return fields.status();
  }
  return line;
}

std::string ToText(const FrameLine& line) {
  // A file name in `reason` may have bytes that are not UTF-8.
  return ToJson(line).dump(-1, ' ', false, Json::error_handler_t::replace);
}

absl::StatusOr<FrameLine> FrameLineFromText(absl::string_view line) {
  const Json json = Json::parse(line.begin(), line.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    return absl::DataLossError("the line is not JSON");
  }
  return FrameLineFromJson(json);
}

}  // namespace egosieve::tools
