#include "vision/frame/frame_source.h"

#include <cctype>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/chapter_sequence.h"
#include "vision/frame/file_list.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/image_sequence.h"
#include "vision/frame/input_files.h"
#include "vision/frame/live_stream.h"
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

absl::Status TimesOfNoPictures(const std::string& input) {
  return absl::InvalidArgumentError(absl::StrCat(
      "times are given for ", input, ", which is no folder or glob of pictures; leave them out"));
}

// How to convert an input that the program does not read; empty for all other inputs.
std::string HowToConvert(const std::string& input) {
  if (IsStreamAddress(input)) {
    return "a stream is read by segment alone, as it comes, and is gone then; give its recording: "
           "segment --record, or ffmpeg -i URL -c copy drive.mp4";
  }
  const std::string extension = absl::AsciiStrToLower(fs::path(input).extension().string());
  if (extension == ".bag" || extension == ".mcap" || extension == ".db3") {
    return "a recording of ROS is not read itself; './run bag FILE --out=DIR' writes its pictures "
           "and a list of them with their times, DIR/pictures.csv, which is read";
  }
  if (const std::string kind = UnreadPictureKind(input); !kind.empty()) {
    return absl::StrCat(kind,
                        " pictures are not read; convert it to JPEG, with ImageMagick: mogrify "
                        "-format jpg ",
                        input);
  }
  return "";
}

absl::StatusOr<std::unique_ptr<FrameSource>> OpenFiles(InputFiles files, const std::string& input,
                                                       const FrameSourceOptions& options) {
  if (files.are_videos && options.times.empty()) {
    return OpenChapters(std::move(files.paths), input, options);
  }
  if (files.are_videos) return TimesOfNoPictures(input);
  std::vector<double> times;
  if (!options.times.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(times, ReadTimes(options.times, files.paths.size()));
  }
  return OpenImageSequence(std::move(files.paths), std::move(times), std::move(files.remarks),
                           input, options);
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
  return a < b;  // they differ only in leading zeros, if at all
}

absl::StatusOr<std::unique_ptr<FrameSource>> OpenFrameSource(const std::string& input,
                                                             const FrameSourceOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (input.empty()) {
    return absl::InvalidArgumentError(
        "the input is empty; give a video file, a folder of pictures or a glob");
  }
  if (const std::string how = HowToConvert(input); !how.empty()) {
    const std::string name = IsStreamAddress(input) ? WithoutCredentials(input) : input;
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", how));
  }
  std::error_code error;
  const fs::file_status status = fs::status(input, error);
  if (!fs::exists(status)) {
    if (input.find_first_of("*?[") == std::string::npos) {
      return absl::NotFoundError(absl::StrCat(input, ": no such file or folder; check the path"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(InputFiles files, FilesOfGlob(input));
    return OpenFiles(std::move(files), input, options);
  }
  if (fs::is_directory(status)) {
    EGOSIEVE_ASSIGN_OR_RETURN(InputFiles files, FilesOfFolder(input));
    return OpenFiles(std::move(files), input, options);
  }
  if (fs::is_character_file(status) && input.starts_with("/dev/video")) {
    return absl::InvalidArgumentError(absl::StrCat(
        input,
        ": a camera is read through a stream; give segment tcp://127.0.0.1:9000 while this "
        "runs: ffmpeg -f v4l2 -i ",
        input, " -f mpegts tcp://127.0.0.1:9000?listen"));
  }
  // A pipe or a device would block, or never end.
  if (!fs::is_regular_file(status)) {
    return absl::InvalidArgumentError(absl::StrCat(
        input, ": neither a file nor a folder; give a video file, a folder of pictures or a glob"));
  }
  if (!options.times.empty()) return TimesOfNoPictures(input);
  if (HasImageExtension(input)) return OpenImageSequence({input}, {}, {}, input, options);
  if (HasListExtension(input)) {
    EGOSIEVE_ASSIGN_OR_RETURN(FileList list, ReadFileList(input));
    if (HasVideoExtension(list.paths.front())) {
      return OpenChapters(std::move(list.paths), input, options);
    }
    return OpenImageSequence(std::move(list.paths), std::move(list.times_seconds),
                             std::move(list.remarks), input, options);
  }
  return OpenVideoFile(input, options);
}

}  // namespace egosieve::vision
