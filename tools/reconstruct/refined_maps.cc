#include "tools/reconstruct/refined_maps.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kFolder[] = "refined";
constexpr char kSuffix[] = ".prob.png";
constexpr char kState[] = "refined.json";

absl::Status CannotRemove(const std::string& path, const std::error_code& error) {
  return absl::UnavailableError(
      absl::StrCat("cannot remove ", path, ": ", error.message(), "; remove it yourself"));
}

}  // namespace

bool RefinedMaps::AreThere() const {
  const absl::StatusOr<std::string> text = ReadFile(folder_.File(kState));
  const auto json = nlohmann::json::parse(text.value_or(""), nullptr, false);
  return json.is_object() && json.value("options", "") == made_with_;
}

bool RefinedMaps::Holds(int64_t index) const {
  std::error_code error;
  return fs::exists(folder_.FrameFile(kFolder, index, kSuffix), error);
}

absl::StatusOr<cv::Mat1f> RefinedMaps::Read(int64_t index, cv::Size size) const {
  return ReadMap(folder_.FrameFile(kFolder, index, kSuffix), size, 1.0);
}

absl::Status RefinedMaps::Begin() const {
  if (AreThere()) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(Remove());
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder_.File(kFolder)));
  const nlohmann::ordered_json json = {{"options", made_with_}};
  return WriteFileAtomically(folder_.File(kState), json.dump(1) + "\n");
}

absl::Status RefinedMaps::Write(int64_t index, const cv::Mat1f& probability) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const EncodedMap encoded, EncodeMap(probability, 1.0));
  return WriteFileAtomically(folder_.FrameFile(kFolder, index, kSuffix), encoded.png);
}

absl::Status RefinedMaps::Remove() const {
  std::error_code error;
  if (fs::is_directory(folder_.File(kFolder), error)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                              ListFolder(folder_.File(kFolder)));
    for (const std::string& name : names) {
      const std::string_view whole = kernels::NameOfTemporary(name);
      if (!(whole.empty() ? std::string_view(name) : whole).ends_with(kSuffix)) continue;
      fs::remove(fs::path(folder_.File(kFolder)) / name, error);
      if (error) return CannotRemove(folder_.File(kFolder), error);
    }
    fs::remove(folder_.File(kFolder), error);  // stays if it holds other files
  }
  // Removed last, so that the next removal completes one that was interrupted.
  fs::remove(folder_.File(kState), error);
  return error ? CannotRemove(folder_.File(kState), error) : absl::OkStatus();
}

cv::Mat1f RoundedMap(const cv::Mat1f& probability) {
  return MapValues(MapPixels(probability, 1.0), 1.0);
}

}  // namespace egosieve::tools
