#include "tools/run/closing_lines.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/verdict.h"

namespace egosieve::tools {

absl::StatusOr<std::string> ClosingLines(const RunFolder& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string tracks, ReadFile(folder.File("tracks.csv")));
  std::vector<std::string> files;
  for (const char* name : {"report.html", "overlay.mp4"}) {
    if (std::filesystem::exists(folder.File(name))) files.push_back(name);
  }
  const bool has_doubt = std::any_of(lines.begin(), lines.end(),
                                     [](const FrameLine& line) { return !DoubtOf(line).empty(); });
  EGOSIEVE_ASSIGN_OR_RETURN(const ShotList shots, ReadShots(folder.path()));
  const std::string cuts = DescribeCuts(shots);
  return absl::StrCat(
      cuts.empty() ? "" : absl::StrCat("cuts:      ", cuts, "\n"),
      "moved:     ", MoversLine(tracks, lines), "\nsure:      ", CertaintyLine(tracks, lines),
      "\ndoubtful:  ", DoubtLine(lines), "\nfiles:     ", folder.path(), ": ",
      absl::StrJoin(files, ", "),
      ", masks/ and ids/ (a picture per frame), tracks.csv\nnext:      ",
      has_doubt ? "look at the doubtful frames in " : "open ", folder.File("report.html"),
      "; masks for other programs: egosieve masks ", folder.path(), " --for=colmap\n");
}

}  // namespace egosieve::tools
