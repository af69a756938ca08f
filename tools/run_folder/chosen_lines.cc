#include "tools/run_folder/chosen_lines.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

bool HasMap(const FrameLine& line) { return line.has_map(); }

bool LacksMap(const FrameLine& line) {
  return !line.has_map() && line.outcome != FrameLine::Outcome::kFailed;
}

// The command that makes the missing maps.
std::string Remedy(const RunFolder& folder) {
  return absl::StrCat("egosieve segment --resume --out=", folder.path(),
                      " with its input and flags");
}

// DataLoss if a map of these lines is missing.
absl::Status CheckFiles(const RunFolder& folder, absl::Span<const FrameLine> lines) {
  const auto is_gone = [&](const FrameLine& line) {
    return line.has_map() && !folder.HoldsMaps(line);
  };
  const auto first = std::find_if(lines.begin(), lines.end(), is_gone);
  if (first == lines.end()) return absl::OkStatus();
  const auto others = std::count_if(first + 1, lines.end(), is_gone);
  return absl::DataLossError(
      absl::StrCat("the map of frame ", first->index, " in ", folder.path(), " is missing or empty",
                   others > 0 ? absl::StrCat(", as are ", others, " others") : "",
                   "; make it again: ", Remedy(folder)));
}

}  // namespace

absl::StatusOr<std::vector<FrameLine>> ChooseLines(const RunFolder& folder,
                                                   const FrameRange& range) {
  EGOSIEVE_RETURN_IF_ERROR(range.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  if (lines.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("the run in ", folder.path(),
                     " has no frame yet; go on with it: egosieve segment --resume"));
  }
  std::vector<FrameLine> chosen;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(chosen),
               [&](const FrameLine& line) { return range.Contains(line.index); });
  if (chosen.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("the run in ", folder.path(), " has frames ",
                                                   lines.front().index, " to ", lines.back().index,
                                                   "; choose --from and --to among them"));
  }
  return chosen;
}

absl::Status CheckMaps(const RunFolder& folder, absl::Span<const FrameLine> lines) {
  if (std::any_of(lines.begin(), lines.end(), HasMap)) {
    return CheckFiles(folder, lines);
  }
  if (std::none_of(lines.begin(), lines.end(), LacksMap)) {
    return absl::FailedPreconditionError(absl::StrCat(
        "no frame of the run in ", folder.path(),
        " that is asked for could be read: ", lines.front().reason, "; choose other frames"));
  }
  return absl::FailedPreconditionError(
      absl::StrCat("the run in ", folder.path(),
                   " has no maps of these frames yet; make them: ", Remedy(folder)));
}

std::string DescribeMissingMaps(const RunFolder& folder, absl::Span<const FrameLine> lines) {
  const auto lacking = std::count_if(lines.begin(), lines.end(), LacksMap);
  if (lacking == 0) return "";
  return absl::StrCat(lacking, " of ", lines.size(), " frames have no map; ", Remedy(folder),
                      " makes them");
}

}  // namespace egosieve::tools
