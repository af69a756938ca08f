// The drives of a batch, and the commands for each: those of a folder or a glob, or of a manifest.
//
// Of a folder: each video, and each folder with pictures or videos in it, or in its subfolder
// frames/ or images/. Everything else is left out.
//
// A manifest is TOML, with one table per drive, in the file's order. Its keys are the drive's input,
// its run folder and flags of `segment`; subtables hold flags of the commands that follow. The table
// `defaults` holds the settings that all drives share; a drive's own keys override it:
//
//   [defaults]
//   out = "out"                        # run folders are out/NAME if a drive names none
//   then = ["refine", "masks"]         # refine and report without it
//   profile = "fast"
//   [defaults.masks]
//   for = "colmap"
//
//   [a]
//   path = "a.mp4"
//   stride = 3
//
// The subtable "research" gives research settings (research_flag.h). "cuts", a list of frame
// numbers, gives the beginnings of a drive's further pieces (plan.h). true means a flag without a
// value; false turns a flag off (--video=false). Paths are relative to the manifest's folder.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct BatchDrive {
  std::string path;  // of the drive's input; absolute, as `out`, once it is read
  std::string out;   // its run folder
  std::map<std::string, std::vector<std::string>> flags = {};  // "--stride=2", by command
  std::vector<std::string> then = {"refine", "report"};        // commands that follow segment
  std::vector<int64_t> cuts = {};  // frames at which a further piece begins, ascending
};

// What the command line says of all drives; it goes before a manifest, except before its run
// folders.
struct BatchSettings {
  std::string out;                         // the folder for the run folders
  std::optional<std::string> then;         // "refine,masks"
  std::string segment_flags, masks_flags;  // "--stride=2 --deterministic"
};

// The commands that may follow segment.
inline constexpr const char* kFollowingCommands[] = {"refine", "masks", "render", "report"};

// Whether the input is a manifest, by its name or as a file that is no video.
bool IsManifest(const std::string& input);

// The drives of all inputs, each a folder, a glob, a video or a manifest. NotFound if nothing is
// there. InvalidArgument for an input without drives, a folder that holds the pictures of one drive,
// and a manifest that cannot be used, naming the drive. What is no drive is a warning.
absl::StatusOr<std::vector<BatchDrive>> ReadDrives(const std::vector<std::string>& inputs,
                                                   const BatchSettings& given);

// folder: the manifest's.
absl::StatusOr<std::vector<BatchDrive>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given = {});
// The frames at which a drive of `frames` frames, `seconds_per_frame` apart, is cut into the fewest
// pieces of equal length that last at most `minutes`. Empty if one piece is enough.
std::vector<int64_t> EqualCuts(int64_t frames, double seconds_per_frame, double minutes);

// Gives cuts to drives without them, from the length in their headers and the time between their
// first two frames. Drives that cannot be read are not cut: their task reports the error.
void CutDrives(double minutes, std::vector<BatchDrive>& drives);

}  // namespace egosieve::tools
