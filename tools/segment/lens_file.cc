#include "tools/segment/lens_file.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

// Models whose parameters begin with one focal length, and with two.
constexpr absl::string_view kOneFocal[] = {"SIMPLE_PINHOLE", "SIMPLE_RADIAL",
                                           "SIMPLE_RADIAL_FISHEYE", "RADIAL", "RADIAL_FISHEYE"};
constexpr absl::string_view kTwoFocals[] = {"PINHOLE",     "OPENCV", "OPENCV_FISHEYE",
                                            "FULL_OPENCV", "FOV",    "THIN_PRISM_FISHEYE"};

template <size_t kCount>
bool Holds(const absl::string_view (&names)[kCount], absl::string_view name) {
  return std::find(names, names + kCount, name) != names + kCount;
}

absl::StatusOr<double> FocalRatioOfLine(absl::string_view line) {
  const std::vector<absl::string_view> words =
      absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  const auto error = [&](absl::string_view what) {
    return absl::DataLossError(absl::StrCat("\"", line, "\": ", what));
  };
  if (words.size() < 5) return error("not CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
  const size_t focals = Holds(kOneFocal, words[1]) ? 1 : Holds(kTwoFocals, words[1]) ? 2 : 0;
  if (focals == 0) return error(absl::StrCat("the model ", words[1], " is not known"));
  double width = 0.0, height = 0.0, sum = 0.0;
  if (!absl::SimpleAtod(words[2], &width) || !absl::SimpleAtod(words[3], &height) || !(width > 0) ||
      !(height > 0)) {
    return error("width and height must be positive numbers");
  }
  if (words.size() < 4 + focals) return error("a focal length is missing");
  for (size_t k = 0; k < focals; ++k) {
    double focal = 0.0;
    if (!absl::SimpleAtod(words[4 + k], &focal) || !(focal > 0) || !std::isfinite(focal)) {
      return error("the focal length must be a positive number");
    }
    sum += focal;
  }
  return sum / static_cast<double>(focals) / std::max(width, height);
}

}  // namespace

absl::StatusOr<double> FocalRatioOfColmap(absl::string_view text) {
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    line = absl::StripAsciiWhitespace(line);
    if (!line.empty() && line[0] != '#') return FocalRatioOfLine(line);
  }
  return absl::DataLossError("there is no camera in it");
}

absl::StatusOr<double> FocalRatioOfCamera(absl::string_view json) {
  const nlohmann::ordered_json parsed =
      nlohmann::ordered_json::parse(json.begin(), json.end(), nullptr, false);
  double focal = 0.0, width = 0.0, height = 0.0;
  JsonFields fields(parsed, "the camera");
  fields.Field("focal_pixels", focal);
  fields.Field("width", width);
  fields.Field("height", height);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  if (!(focal > 0.0) || !(width > 0.0)) {
    return absl::DataLossError(absl::StrFormat(
        "the camera: focal_pixels = %g, width = %g; they must be positive", focal, width));
  }
  return focal / std::max(width, height);
}

absl::StatusOr<double> ReadFocalRatio(const std::string& path) {
  if (absl::EndsWith(path, ".txt")) return ParseFile(path, FocalRatioOfColmap);
  return ParseFile(path, FocalRatioOfCamera);
}

}  // namespace egosieve::tools
