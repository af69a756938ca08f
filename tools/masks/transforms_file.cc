#include "tools/masks/transforms_file.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/strip.h"
#include "kernels/base/status_macros.h"
#include "tools/masks/mask_format.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr char kName[] = "transforms.json";

absl::StatusOr<std::string> Find(const std::string& path, const std::string& input) {
  std::error_code error;
  const fs::path folder = fs::absolute(input).lexically_normal();
  const fs::path given(path);
  const std::vector<fs::path> candidates =
      path.empty() ? std::vector<fs::path>{folder / kName, folder.parent_path() / kName}
                   : std::vector<fs::path>{given, given / kName};
  for (const fs::path& candidate : candidates) {
    if (fs::is_regular_file(candidate, error)) return candidate.string();
  }
  return absl::NotFoundError(
      absl::StrCat(path.empty() ? absl::StrCat("there is no ", kName, " in ", input, " or above it")
                                : absl::StrCat("--transforms=", path, ": no such file"),
                   "; give nerfstudio's, as ns-process-data writes it, to --transforms"));
}

// As Windows' programs write paths.
std::string WithSlashes(const std::string& path) {
  return absl::StrReplaceAll(path, {{"\\", "/"}});
}

// Images by their names, and by their names without extension, where one alone has it.
std::map<std::string, std::string> ByName(const std::vector<std::string>& images) {
  std::map<std::string, std::string> names;
  for (const std::string& image : images) {
    const auto [at, is_new] = names.emplace(fs::path(image).replace_extension().string(), image);
    if (!is_new) at->second.clear();
  }
  for (const std::string& image : images) names[image] = image;
  return names;
}

// The image whose name ends the path, longest name first; empty if there is none.
std::string ImageOf(const fs::path& path, const std::map<std::string, std::string>& images) {
  for (auto begin = path.begin(); begin != path.end(); ++begin) {
    fs::path end;
    for (auto part = begin; part != path.end(); ++part) end /= *part;
    if (const auto image = images.find(end.string()); image != images.end()) return image->second;
  }
  return "";
}

// N of the folders images_N.
std::vector<int> ReductionsIn(const fs::path& folder) {
  std::vector<int> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    absl::string_view number = name;
    int by = 0;
    if (absl::ConsumePrefix(&number, "images_") && absl::SimpleAtoi(number, &by) && by > 1 &&
        entry.is_directory(error)) {
      found.push_back(by);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Makes here/NAME a link to there/NAME, if that is a folder.
absl::Status LinkFolder(const fs::path& there, const fs::path& here, const std::string& name) {
  std::error_code error;
  const fs::path link = here / name;
  if (!fs::is_directory(there / name, error)) return absl::OkStatus();
  if (fs::is_symlink(link, error)) fs::remove(link, error);
  fs::create_directory_symlink((there / name).lexically_relative(here), link, error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("cannot make the link ", link.string(), ": ",
                                             error.message(), "; choose another --out"));
}

}  // namespace

absl::StatusOr<TransformsFile> TransformsFile::Read(const std::string& path,
                                                    const std::string& input,
                                                    const std::vector<std::string>& images) {
  TransformsFile file;
  EGOSIEVE_ASSIGN_OR_RETURN(file.path_, Find(path, input));
  file.reductions_ = ReductionsIn(fs::absolute(file.path_).parent_path());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(file.path_));
  file.json_ = Json::parse(text, nullptr, false);
  const auto frames = file.json_.is_object() ? file.json_.find("frames") : file.json_.end();
  if (!file.json_.is_object() || frames == file.json_.end() || !frames->is_array()) {
    return absl::DataLossError(
        absl::StrCat(file.path_, " is no transforms.json: it has no list of frames"));
  }
  const std::map<std::string, std::string> names = ByName(images);
  for (const Json& frame : *frames) {
    const std::string name =
        frame.is_object() && frame.contains("file_path") && frame["file_path"].is_string()
            ? WithSlashes(frame["file_path"].get<std::string>())
            : "";
    file.images_.push_back(ImageOf(fs::path(name).lexically_normal(), names));
    if (file.images_.back().empty()) {
      return absl::DataLossError(absl::StrCat(file.path_, ": file_path '", name,
                                              "' is no image of ", input,
                                              "; give the images that it was made from"));
    }
  }
  return file;
}

absl::StatusOr<int> TransformsFile::Write(const std::string& folder,
                                          const std::set<std::string>& masked) const {
  std::error_code error;
  const fs::path here = fs::weakly_canonical(folder, error);
  const fs::path there = fs::weakly_canonical(fs::path(path_).parent_path(), error);
  const auto rebase = [&](Json& value) {
    if (!value.is_string()) return;
    const fs::path path = WithSlashes(value.get<std::string>());
    if (!path.is_absolute())
      value = (there / path).lexically_normal().lexically_relative(here).string();
  };
  Json copy = json_;
  if (copy.contains("ply_file_path")) rebase(copy["ply_file_path"]);
  for (const char* key : {"train_filenames", "val_filenames", "test_filenames"}) {
    if (copy.contains(key) && copy[key].is_array()) {
      for (Json& name : copy[key]) rebase(name);
    }
  }
  Json frames = Json::array();
  int left_out = 0;
  for (size_t i = 0; i < images_.size(); ++i) {
    if (masked.count(images_[i]) == 0) {
      ++left_out;
      continue;
    }
    Json frame = copy["frames"][i];
    for (const char* key : {"file_path", "depth_file_path"}) {
      if (frame.contains(key)) rebase(frame[key]);
    }
    const fs::path file = frame["file_path"].get<std::string>();
    const std::string extension = fs::path(images_[i]).extension().string();
    if (file.extension() != extension) frame["file_path"] = file.string() + extension;
    frame["mask_path"] = MaskFile(MaskFormat::kNerfstudio, images_[i], 0, "");
    frames.push_back(std::move(frame));
  }
  copy["frames"] = std::move(frames);
  if (here != there) {
    for (const int by : reductions_) {
      EGOSIEVE_RETURN_IF_ERROR(LinkFolder(there, here, absl::StrCat("images_", by)));
      EGOSIEVE_RETURN_IF_ERROR(LinkFolder(there, here, absl::StrCat("depths_", by)));
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically((fs::path(folder) / kName).string(), copy.dump(2) + "\n"));
  return left_out;
}

}  // namespace egosieve::tools
