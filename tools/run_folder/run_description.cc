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
  fields.Read("format_version", format);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  if (format > kRunFormat) {
    return absl::FailedPreconditionError(
        absl::StrCat("its format ", format, " is newer than this program's ", kRunFormat,
                     "; use the version of egosieve that wrote it"));
  }
  if (format < kRunFormat) {
    return absl::FailedPreconditionError(
        absl::StrCat("its format ", format, " is older than this program's ", kRunFormat,
                     "; segment the drive again, or use the version of egosieve that wrote it"));
  }
  return absl::OkStatus();
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
  const kernels::ImageGrid& grid = description.grid;
  Json json = {
      {"format", kFormatName},
      {"format_version", kRunFormat},
      {"version", description.version},
      {"flags", description.flags},
      {"device", description.device},
      {"seed", description.seed},
      {"input",
       {{"path", JsonName(description.input.path)},
        {"kind", description.input.kind},
        {"fingerprint", description.input.fingerprint},
        {"width_pixels", grid.width},
        {"height_pixels", grid.height}}},
      {"maps",
       {{"stride_pixels", grid.stride},
        {"columns", grid.columns()},
        {"rows", grid.rows()},
        {"probability", "value / 65535"},
        {"deviation", "of the latent function: value / 65535 * deviation_full_scale"},
        {"deviation_full_scale", description.deviation_full_scale}}},
      {"ended", description.ended},
      {"ended_message", description.ended_message},
      {"frames_answered", description.frames_answered},
      {"frames_learnt", description.frames_learnt},
      {"frames_failed", description.frames_failed},
      {"seconds", description.seconds},
      {"started_utc", description.started_utc},
      {"finished_utc", description.finished_utc},
  };
  if (!description.input.remarks.empty()) json["input"]["remarks"] = description.input.remarks;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<RunDescription> RunDescriptionFromText(absl::string_view text) {
  const Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    return absl::DataLossError("it is not JSON");
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckFormat(json));
  RunDescription description;
  JsonFields fields(json, "it");
  fields.Read("version", description.version);
  fields.Read("flags", description.flags);
  fields.Read("device", description.device);
  fields.Read("seed", description.seed);
  JsonFields input(fields.Object("input"), "its 'input'");
  input.Read("path", description.input.path);
  description.input.path = NameFromJson(description.input.path);
  input.Read("kind", description.input.kind);
  input.Read("fingerprint", description.input.fingerprint);
  input.ReadIfThere("remarks", description.input.remarks);
  input.Read("width_pixels", description.grid.width);
  input.Read("height_pixels", description.grid.height);
  JsonFields maps(fields.Object("maps"), "its 'maps'");
  maps.Read("stride_pixels", description.grid.stride);
  maps.Read("deviation_full_scale", description.deviation_full_scale);
  fields.Read("ended", description.ended);
  fields.Read("ended_message", description.ended_message);
  fields.Read("frames_answered", description.frames_answered);
  fields.Read("frames_learnt", description.frames_learnt);
  fields.Read("frames_failed", description.frames_failed);
  fields.Read("seconds", description.seconds);
  fields.Read("started_utc", description.started_utc);
  fields.Read("finished_utc", description.finished_utc);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  EGOSIEVE_RETURN_IF_ERROR(input.status());
  EGOSIEVE_RETURN_IF_ERROR(maps.status());
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
  const auto size = [](const kernels::ImageGrid& grid) {
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
