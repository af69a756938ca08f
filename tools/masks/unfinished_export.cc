#include "tools/masks/unfinished_export.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/masks/mask_export.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string MarkPath(const MaskExportOptions& options) {
  return options.out + "/.egosieve_masks.json";
}

std::string Settings(const MaskExportOptions& options, const RunDescription::Input& input) {
  const FrameMaskOptions& mask = options.mask;
  return absl::StrFormat(
      "format=%d threshold=%g dilate=%d shadow=%d own_vehicle=%d invert=%d also=%s video=%s "
      "frames=%s input=%s",
      static_cast<int>(options.format), mask.threshold.value_or(-1.0), mask.dilate_pixels,
      mask.shadow_margin_pixels, mask.own_vehicle ? 1 : 0, options.invert ? 1 : 0, options.also,
      options.video, options.frames, input.fingerprint);
}

// What the masks are made from.
absl::StatusOr<std::string> RunIn(const RunFolder& run) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, run.ReadDescription());
  const Json made =
      Json::parse(ReadFile(run.File("reconstruct.json")).value_or(""), nullptr, false);
  return absl::StrCat(description.started_utc, " ", description.finished_utc, " ",
                      made.is_object() ? made.value("options", "") : "");
}

Json ReadMark(const MaskExportOptions& options) {
  return Json::parse(ReadFile(MarkPath(options)).value_or(""), nullptr, false);
}

bool IsEmpty(const std::string& folder) {
  std::error_code error;
  return folder.empty() || !fs::exists(folder, error) || fs::is_empty(folder, error);
}

}  // namespace

bool UnfinishedExport::IsIn(const MaskExportOptions& options, const RunDescription::Input& input) {
  const Json mark = ReadMark(options);
  return mark.is_object() && mark.value("settings", "") == Settings(options, input);
}

absl::StatusOr<UnfinishedExport> UnfinishedExport::Begin(const MaskExportOptions& options,
                                                         const RunDescription::Input& input,
                                                         const RunFolder& run) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string run_text, RunIn(run));
  const Json before = ReadMark(options);
  const bool continues = IsIn(options, input) && before.value("run", "") == run_text &&
                         before.value("began_empty", false);
  const bool began_empty = continues || (IsEmpty(options.out) && IsEmpty(options.frames));
  const Json mark = {
      {"settings", Settings(options, input)}, {"run", run_text}, {"began_empty", began_empty}};
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(MarkPath(options), mark.dump(1) + "\n"));
  return UnfinishedExport(MarkPath(options), continues);
}

absl::Status UnfinishedExport::End() const {
  std::error_code error;
  fs::remove(path_, error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat("cannot remove ", path_, ": ", error.message(), "; remove it yourself"));
}

}  // namespace egosieve::tools
