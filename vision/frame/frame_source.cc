#include "vision/frame/frame_source.h"

#include <glob.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/image_sequence.h"
#include "vision/frame/video_file.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// The run of digits at `begin`, without leading zeros.
std::string_view DigitRun(std::string_view text, size_t begin, size_t* end) {
  *end = begin;
  while (*end < text.size() && IsDigit(text[*end])) ++*end;
  while (begin + 1 < *end && text[begin] == '0') ++begin;
  return text.substr(begin, *end - begin);
}

bool IsVisibleImage(const fs::path& path) {
  std::error_code error;
  return !path.filename().string().starts_with('.') && HasImageExtension(path.string()) &&
         fs::is_regular_file(path, error);
}

absl::StatusOr<std::vector<std::string>> ImagesInFolder(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (IsVisibleImage(it->path())) paths.push_back(it->path().string());
  }
  if (error) {
    return absl::NotFoundError(
        absl::StrCat(folder, ": the folder cannot be read (", error.message(), ")"));
  }
  if (paths.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        folder, ": no pictures in this folder; give a folder that holds PNG or JPEG files itself"));
  }
  return paths;
}

absl::StatusOr<std::vector<std::string>> ImagesOfGlob(const std::string& pattern) {
  std::vector<std::string> paths;
  size_t match_count = 0;
  glob_t matches = {};
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &matches) == 0) {
    match_count = matches.gl_pathc;
    for (size_t i = 0; i < matches.gl_pathc; ++i) {
      if (IsVisibleImage(matches.gl_pathv[i])) paths.push_back(matches.gl_pathv[i]);
    }
  }
  globfree(&matches);
  if (match_count == 0) {
    return absl::NotFoundError(
        absl::StrCat(pattern, ": no file matches; quote the pattern and check the folder"));
  }
  if (paths.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(pattern, ": matches ", match_count,
                     " files, none of them a picture; name a video by itself"));
  }
  return paths;
}

}  // namespace

absl::Status FrameSourceOptions::Validate() const {
  if (!(nominal_rate_hz > 0) || !std::isfinite(nominal_rate_hz)) {
    return absl::InvalidArgumentError(
        absl::StrCat("nominal_rate_hz is ", nominal_rate_hz, "; it must be positive"));
  }
  return absl::OkStatus();
}

std::string FrameSource::image_name(int64_t index) const {
  return absl::StrFormat("%06d.png", index);
}

bool NaturalLess(const std::string& a, const std::string& b) {
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const std::string_view x = DigitRun(a, i, &i), y = DigitRun(b, j, &j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      const auto x = static_cast<unsigned char>(a[i++]), y = static_cast<unsigned char>(b[j++]);
      if (x != y) return x < y;
    }
  }
  const size_t rest_a = a.size() - i, rest_b = b.size() - j;
  if (rest_a != 0 || rest_b != 0) return rest_a < rest_b;
  return a < b;  // they differ in leading zeros at most
}

absl::StatusOr<std::unique_ptr<FrameSource>> OpenFrameSource(const std::string& input,
                                                             const FrameSourceOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (input.empty()) {
    return absl::InvalidArgumentError(
        "the input is empty; give a video file, a folder of pictures or a glob");
  }
  std::error_code error;
  const fs::file_status status = fs::status(input, error);
  if (!fs::exists(status)) {
    if (input.find_first_of("*?[") == std::string::npos) {
      return absl::NotFoundError(absl::StrCat(input, ": no such file or folder; check the path"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<std::string> paths, ImagesOfGlob(input));
    std::sort(paths.begin(), paths.end(), NaturalLess);
    return OpenImageSequence(std::move(paths), input, options);
  }
  if (fs::is_directory(status)) {
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<std::string> paths, ImagesInFolder(input));
    std::sort(paths.begin(), paths.end(), NaturalLess);
    return OpenImageSequence(std::move(paths), input, options);
  }
  // A pipe or a device would be waited for, or never end.
  if (!fs::is_regular_file(status)) {
    return absl::InvalidArgumentError(absl::StrCat(
        input, ": neither a file nor a folder; give a video file, a folder of pictures or a glob"));
  }
  if (HasImageExtension(input)) return OpenImageSequence({input}, input, options);
  return OpenVideoFile(input, options);
}

}  // namespace egosieve::vision
