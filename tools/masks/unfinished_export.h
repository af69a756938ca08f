// The mark of an export that has begun and not ended, OUT/.egosieve_masks.json, by which the same
// command continues it: with which options, of which run, and whether the folders were empty
// before.
#pragma once

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

struct MaskExportOptions;

class UnfinishedExport {
 public:
  // Whether options.out holds an export of these options and this input that has not ended.
  static bool IsIn(const MaskExportOptions& options, const RunDescription::Input& input);
  // Writes the mark.
  static absl::StatusOr<UnfinishedExport> Begin(const MaskExportOptions& options,
                                                const RunDescription::Input& input,
                                                const RunFolder& run);

  // Whether every file in the folders was made by the same export of the same run.
  bool continues() const { return continues_; }
  // Removes the mark.
  absl::Status End() const;

 private:
  UnfinishedExport(std::string path, bool continues)
      : path_(std::move(path)), continues_(continues) {}

  std::string path_;
  bool continues_;
};

}  // namespace egosieve::tools
