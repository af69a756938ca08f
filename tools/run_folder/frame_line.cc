#include "tools/run_folder/frame_line.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <iterator>
#include <stdexcept>

#include "absl/status/status.h"
#include "tools/run_folder/json_fields.h"

namespace nlohmann {

using egosieve::vision::CameraStep;

// null if not known.
template <>
struct adl_serializer<CameraStep> {
  static void to_json(ordered_json& json, const CameraStep& step) {
    const auto list = [](const Eigen::Vector3d& v) { return ordered_json{v(0), v(1), v(2)}; };
    json = nullptr;
    if (!step.known) return;
    json = {{"rotation", list(step.rotation)},
            {"direction", list(step.direction)},
            {"onward", step.onward},
            {"heights", step.heights}};
  }
  static void from_json(const ordered_json& json, CameraStep& step) {
    step.known = !json.is_null();
    if (!step.known) return;
    step.rotation = Eigen::Vector3d(json.at("rotation").get<std::array<double, 3>>().data());
    step.direction = Eigen::Vector3d(json.at("direction").get<std::array<double, 3>>().data());
    json.at("onward").get_to(step.onward);
    json.at("heights").get_to(step.heights);
  }
};

}  // namespace nlohmann

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using Outcome = FrameLine::Outcome;

constexpr const char* kOutcomes[] = {"learnt", "answered", "failed"};

template <typename Line, typename Fields>
void Walk(Line& line, Fields& fields) {
  fields.Field("index", line.index);
  fields.Field("image", line.image);
  fields.Field("time_seconds", line.time_seconds);
  fields.Field("outcome", line.outcome);
  fields.OrNull("reason", line.reason);
  fields.OrNull("doubt", line.doubt);
  fields.Field("width_pixels", line.width_pixels);
  fields.Field("height_pixels", line.height_pixels);
  fields.Field("features", line.features);
  fields.Field("matches", line.matches);
  fields.Field("motion_model", line.motion_model);
  fields.Field("inliers", line.inliers);
  fields.Field("noise_pixels", line.noise_pixels);
  fields.Field("labelled_static", line.labelled_static);
  fields.Field("labelled_dynamic", line.labelled_dynamic);
  fields.Field("frame_gap", line.frame_gap);
  fields.Numbers("decided_by", line.decided_by);
  fields.Field("step", line.step);
  fields.Object("points", [&](auto& counts) {
    counts.Field("candidates", line.points.candidates);
    counts.Field("dropped_by_density", line.points.dropped_by_density);
    counts.Field("dropped_by_novelty", line.points.dropped_by_novelty);
    counts.Field("added", line.points.added);
    counts.Field("dropped_by_consistency", line.points.dropped_by_consistency);
    counts.Field("dropped_by_model_density", line.points.dropped_by_model_density);
    counts.Field("dropped_by_age", line.points.dropped_by_age);
    counts.Field("dropped_by_budget", line.points.dropped_by_budget);
  });
  fields.Field("model_size", line.model_size);
  fields.Field("theta", line.theta);
  fields.Field("a", line.a);
  fields.Field("b", line.b);
  fields.Field("log_likelihood_per_point", line.log_likelihood_per_point);
  fields.Field("factor_rebuilt", line.factor_rebuilt);
  fields.Field("jitter", line.jitter);
  fields.Field("dynamic_share", line.dynamic_share);
  fields.Field("expected_overlap", line.expected_overlap);
  fields.Field("clamped_variances", line.clamped_variances);
  fields.Field("saturated_deviations", line.saturated_deviations);
  fields.Optional("map_device", line.map_device);
  fields.Numbers("milliseconds", line.milliseconds);
}

}  // namespace

void to_json(Json& json, Outcome outcome) { json = kOutcomes[static_cast<int>(outcome)]; }

void from_json(const Json& json, Outcome& outcome) {
  const auto name = std::ranges::find(kOutcomes, json.get<std::string>());
  if (name == std::end(kOutcomes)) throw std::invalid_argument("no outcome");
  outcome = static_cast<Outcome>(name - kOutcomes);
}

Json ToJson(const FrameLine& line) {
  JsonWriter fields;
  Walk(line, fields);
  return fields.json();
}

absl::StatusOr<FrameLine> FrameLineFromJson(const Json& json) {
  FrameLine line;
  JsonFields fields(json, "the frame's line");
  Walk(line, fields);
  if (!fields.status().ok()) return fields.status();
  return line;
}

std::string ToText(const FrameLine& line) { return ToJson(line).dump(); }

absl::StatusOr<FrameLine> FrameLineFromText(absl::string_view line) {
  const Json json = Json::parse(line.begin(), line.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    return absl::DataLossError("the line is not JSON");
  }
  return FrameLineFromJson(json);
}

}  // namespace egosieve::tools
