#include "tools/run_folder/run_description.h"

#include <nlohmann/json.hpp>
#include <set>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/json_fields.h"
#include "tools/run_folder/json_name.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kFormatName[] = "egosieve run";

absl::Status CheckFormat(const Json& json) {
  if (!json.is_object() || json.value("format", Json()) != kFormatName) {
    return absl::DataLossError("it does not describe a run of egosieve");
  }
  int format = 0;
  JsonFields fields(json, "run.json");
  fields.Field("format_version", format);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  if (format != kRunFormat) {
    return absl::FailedPreconditionError(
        absl::StrCat("its format is ", format, ", this program's ", kRunFormat,
                     "; segment the drive again, or use the version of egosieve that wrote it"));
  }
  return absl::OkStatus();
}

template <typename Description, typename Fields>
void WalkRun(Description& run, Fields& fields) {
  auto& grid = run.grid;
  fields.Told("format", [] { return kFormatName; });
  fields.Told("format_version", [] { return kRunFormat; });
  fields.Field("version", run.version);
  fields.Field("flags", run.flags);
  fields.Field("device", run.device);
  fields.Field("seed", run.seed);
  fields.Object("input", [&](auto& input) {
    input.Field("path", run.input.path);
    input.Field("kind", run.input.kind);
    input.Field("fingerprint", run.input.fingerprint);
    input.Field("width_pixels", grid.width);
    input.Field("height_pixels", grid.height);
    input.Optional("remarks", run.input.remarks);
  });
  fields.Object("maps", [&](auto& maps) {
    maps.Field("stride_pixels", grid.stride);
    maps.Told("columns", [&] { return grid.columns(); });
    maps.Told("rows", [&] { return grid.rows(); });
    maps.Told("probability", [] { return "value / 65535"; });
    maps.Told("deviation",
              [] { return "of the latent function: value / 65535 * deviation_full_scale"; });
    maps.Field("deviation_full_scale", run.deviation_full_scale);
  });
  fields.Field("ended", run.ended);
  fields.Field("ended_message", run.ended_message);
  fields.Field("frames_answered", run.frames_answered);
  fields.Field("frames_learnt", run.frames_learnt);
  fields.Field("frames_failed", run.frames_failed);
  fields.Field("seconds", run.seconds);
  fields.Field("started_utc", run.started_utc);
  fields.Field("finished_utc", run.finished_utc);
}

std::string Quoted(const std::map<std::string, std::string>& flags, const std::string& name) {
  const auto flag = flags.find(name);
  return flag == flags.end() ? "absent" : absl::StrCat("'", flag->second, "'");
}

std::string Difference(const std::string& what, const std::string& before, const std::string& now) {
  return before == now ? "" : absl::StrCat(what, " is ", before, " there and ", now, " here");
}

}  // namespace

std::string ToText(const RunDescription& description) {
  JsonWriter fields;
  WalkRun(description, fields);
  return fields.json().dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<RunDescription> RunDescriptionFromText(absl::string_view text) {
  const Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    return absl::DataLossError("it is not JSON");
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckFormat(json));
  RunDescription description;
  JsonFields fields(json, "it");
  WalkRun(description, fields);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  description.input.path = NameFromJson(description.input.path);
  if (const absl::Status grid = description.grid.Validate(); !grid.ok()) {
    return absl::DataLossError(grid.message());
  }
  if (!(description.deviation_full_scale > 0.0)) {
    return absl::DataLossError(absl::StrCat(
        "deviation_full_scale = ", description.deviation_full_scale, "; it must be positive"));
  }
  return description;
}

std::string DescribeDifference(const RunDescription& before, const RunDescription& now) {
  std::set<std::string> names;
  for (const auto& flags : {before.flags, now.flags}) {
    for (const auto& [name, value] : flags) {
      names.insert(name);
    }
  }
  for (const std::string& name : names) {
    const std::string difference =
        Difference(name, Quoted(before.flags, name), Quoted(now.flags, name));
    if (!difference.empty()) return difference;
  }
  const auto size = [](const vision::ImageGrid& grid) {
    return absl::StrCat(grid.width, " x ", grid.height);
  };
  for (const std::string& difference :
       {Difference("the program's version", before.version, now.version),
        Difference("the input", before.input.path, now.input.path),
        Difference("the size of the frames", size(before.grid), size(now.grid)),
        Difference("the input's content", before.input.fingerprint, now.input.fingerprint),
        Difference("the device", before.device, now.device)}) {
    if (!difference.empty()) return difference;
  }
  return "";
}

}  // namespace egosieve::tools
