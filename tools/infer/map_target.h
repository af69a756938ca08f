// The folder that infer fills: the run itself, or a folder of --out that holds only maps. The
// caller holds the lock of FolderLock::Take on it.
#ifndef EGOSIEVE_TOOLS_INFER_MAP_TARGET_H_
#define EGOSIEVE_TOOLS_INFER_MAP_TARGET_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/infer/map_book.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

struct MapTarget {
  std::string run;         // folder with the models
  std::string out;         // empty: the run itself
  bool overwrite = false;  // replace the run that `out` holds

  bool is_run() const { return out.empty(); }
  const std::string& path() const { return is_run() ? run : out; }

  // Checks that no input would be replaced. Links and other spellings of a path are resolved.
  absl::Status CheckApartFrom(const vision::FrameSource& frames) const;

  // `description` is the run's. A folder of --out is new, or one that an earlier call has begun:
  // AlreadyExists if it holds other maps. Another device may continue it.
  absl::StatusOr<MapBook> Open(const RunFolder& folder, const RunDescription& description,
                               int stride_pixels, const std::string& device) const;

  // Writes the end of the work into run.json of --out, with the counts of all maps so far. The
  // run.json of a run is not changed. finished: false if interrupted.
  absl::Status TellEnd(const absl::StatusOr<bool>& finished, double seconds) const;

 private:
  absl::StatusOr<RunFolder> OpenOut(const RunDescription& description) const;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_MAP_TARGET_H_
