// nerfstudio's transforms.json, to which masks are added.
//
// A frame is an image's where its file_path ends in the image's name, folders included; of several
// images the one with the longest name. nerfstudio wants a mask for every frame or for none.
#ifndef EGOSIEVE_TOOLS_MASKS_TRANSFORMS_FILE_H_
#define EGOSIEVE_TOOLS_MASKS_TRANSFORMS_FILE_H_

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

class TransformsFile {
 public:
  // path: the file; empty: that in the images' folder or in the one that holds it. NotFound where
  // there is none; DataLoss where it is none of nerfstudio's, or has frames that are no image's.
  static absl::StatusOr<TransformsFile> Read(const std::string& path, const std::string& input,
                                             const std::vector<std::string>& images);

  // Writes folder/transforms.json: each frame of an image in `masked` with its mask_path, paths to
  // the pictures as seen from there; other frames are left out. Returns how many those are.
  absl::StatusOr<int> Write(const std::string& folder, const std::set<std::string>& masked) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
  std::vector<std::string> images_;  // by frame
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MASKS_TRANSFORMS_FILE_H_
