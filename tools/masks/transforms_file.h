// nerfstudio's transforms.json, to which masks are added.
//
// A frame belongs to an image if its file_path ends in the image's name, including folders; of
// several such images, to the one with the longest name. Folders may be separated by backslashes,
// and a file_path without an extension means the one image that has its name. The copy has slashes
// and extensions. nerfstudio needs a mask for every frame or for none.
//
// Reduced pictures lie beside transforms.json in images_2, images_4 and so on. nerfstudio takes
// those where the pictures have more than 1600 pixels, or where it is told to, and then masks of
// the same size (mask_format.h).
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

class TransformsFile {
 public:
  // path: the file; empty: the one in the images' folder or in its parent. NotFound if there is
  // none. DataLoss if it is not a file of nerfstudio, or has frames without an image or with one of
  // several.
  static absl::StatusOr<TransformsFile> Read(const std::string& path, const std::string& input,
                                             const std::vector<std::string>& images);

  // N of the folders images_N, ascending.
  const std::vector<int>& reductions() const { return reductions_; }

  // Writes folder/transforms.json: every frame whose image is in `masked`, with its mask_path and
  // with paths to the pictures relative to that folder. Other frames are left out; their number is
  // returned. Links to images_N and depths_N lie beside it.
  absl::StatusOr<int> Write(const std::string& folder, const std::set<std::string>& masked) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
  std::vector<std::string> images_;  // by frame
  std::vector<int> reductions_;
};

}  // namespace egosieve::tools
