#include "vision/frame/frame_source.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/file_list.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/input_files.h"
#include "vision/frame/video_file.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

// The input if it is a folder, else the deepest folder that holds all files.
fs::path RootOf(const std::string& input, const std::vector<std::string>& paths) {
  std::error_code error;
  if (fs::is_directory(input, error)) return input;
  fs::path root = fs::path(paths.front()).parent_path();
  for (const std::string& path : paths) {
    const fs::path folder = fs::path(path).parent_path();
    const auto end = std::mismatch(root.begin(), root.end(), folder.begin(), folder.end()).first;
    fs::path shared;
    for (auto part = root.begin(); part != end; ++part) shared /= *part;
    root = shared;
  }
  return root;
}

// Frames from picture files, in the order given, at their times or those of the nominal rate.
class ImageSequence : public FrameSource {
 public:
  ImageSequence(InputFiles files, const std::optional<ValueRange>& range, std::string description,
                double rate_hz)
      : files_(std::move(files)),
        range_(range),
        description_(std::move(description)),
        rate_hz_(rate_hz),
        root_(RootOf(description_, files_.paths)) {}

  absl::StatusOr<FrameRead> Next() override {
    const int64_t index = next_index_;
    if (index >= expected_frame_count()) return FrameRead(EndOfFrames{expected_frame_count(), ""});
    absl::StatusOr<DecodedImage> decoded = DecodeImageFile(files_.paths[index], range_);
    if (kernels::IsOfTheMachine(decoded.status())) return decoded.status();
    ++next_index_;
    if (!decoded.ok()) {
      return FrameRead(DamagedFrame{index, std::string(decoded.status().message())});
    }
    const double seconds = files_.times_seconds.empty() ? static_cast<double>(index) / rate_hz_
                                                        : files_.times_seconds[index];
    return FrameRead(Frame{index, seconds, decoded->image, decoded->is_grey});
  }

  absl::Status SeekTo(int64_t index) override {
    if (index < 0) return absl::InvalidArgumentError(absl::StrCat("frame index ", index, " < 0"));
    next_index_ = index;
    return absl::OkStatus();
  }

  int64_t next_index() const override { return next_index_; }
  int64_t expected_frame_count() const override {
    return static_cast<int64_t>(files_.paths.size());
  }
  std::vector<std::string> files() const override { return files_.paths; }
  std::string image_name(int64_t index) const override {
    if (index < 0 || index >= expected_frame_count()) return FrameSource::image_name(index);
    const fs::path path(files_.paths[index]);
    return (root_.empty() ? path : path.lexically_relative(root_)).string();
  }
  std::string description() const override { return description_; }
  std::vector<std::string> remarks() const override { return files_.remarks; }

 private:
  const InputFiles files_;
  const std::optional<ValueRange> range_;
  const std::string description_;
  const double rate_hz_;
  const fs::path root_;
  int64_t next_index_ = 0;
};

absl::StatusOr<std::unique_ptr<FrameSource>> OpenImageSequence(InputFiles files,
                                                               const std::string& description,
                                                               const FrameSourceOptions& options) {
  std::string first_reason;
  for (const std::string& path : files.paths) {
    const absl::StatusOr<DecodedImage> decoded = DecodeImageFile(path);
    if (kernels::IsOfTheMachine(decoded.status())) return decoded.status();
    if (decoded.ok()) {
      EGOSIEVE_ASSIGN_OR_RETURN(const auto range, RangeOfDrive(files.paths));
      if (range) {
        files.remarks.push_back(absl::StrFormat(
            "the pictures use a part of their range; values from %g to %g become 0 to 255, in all "
            "of them alike",
            range->low, range->high));
      }
      return std::make_unique<ImageSequence>(std::move(files), range, description,
                                             options.nominal_rate_hz);
    }
    if (first_reason.empty()) first_reason = std::string(decoded.status().message());
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "none of the ", files.paths.size(), " picture files can be read; the first: ", first_reason,
      "; give readable pictures"));
}

// One drive from several videos, in the order given. Each video is opened once to check that it can
// be read; the others are left out, and the warning at the end names them. A chapter's first frame
// follows the last frame of the previous chapter by that chapter's frame interval, since files do
// not state how long the camera paused. The frames before an index are counted, not estimated.
class ChapterSequence : public FrameSource {
 public:
  ChapterSequence(std::vector<std::string> paths, std::string description,
                  FrameSourceOptions options, int64_t expected_frame_count,
                  std::vector<std::string> warnings)
      : paths_(std::move(paths)),
        description_(std::move(description)),
        options_(std::move(options)),
        expected_frame_count_(expected_frame_count),
        warnings_(std::move(warnings)) {}

  absl::StatusOr<FrameRead> Next() override {
    while (true) {
      EGOSIEVE_RETURN_IF_ERROR(OpenChapter());
      EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source_->Next());
      const Start& start = starts_[chapter_];
      if (auto* frame = std::get_if<Frame>(&read)) {
        frame->index += start.index;
        frame->time_seconds += start.seconds;
      } else if (auto* damaged = std::get_if<DamagedFrame>(&read)) {
        damaged->index += start.index;
      } else {
        const auto& end = std::get<EndOfFrames>(read);
        const Start next = {start.index + end.frame_count, start.seconds + end.end_seconds};
        if (starts_.size() == chapter_ + 1) {
          starts_.push_back(next);
          if (!end.warning.empty()) warnings_.push_back(end.warning);
        }
        if (chapter_ + 1 == paths_.size()) {
          return FrameRead(EndOfFrames{next.index, absl::StrJoin(warnings_, "; "), next.seconds});
        }
        ++chapter_;
        source_.reset();
        continue;
      }
      ++next_index_;
      return read;
    }
  }

  absl::Status SeekTo(int64_t index) override {
    if (index < 0) return absl::InvalidArgumentError(absl::StrCat("frame index ", index, " < 0"));
    next_index_ = index;
    const auto behind = std::find_if(starts_.begin(), starts_.end(),
                                     [&](const Start& s) { return s.index > index; });
    const size_t chapter =
        std::min<size_t>(behind - starts_.begin(), paths_.size()) - 1;  // the first starts at 0
    if (source_ == nullptr || chapter != chapter_) {
      chapter_ = chapter;
      source_.reset();
      return absl::OkStatus();
    }
    return source_->SeekTo(index - starts_[chapter_].index);
  }

  int64_t next_index() const override { return next_index_; }
  int64_t expected_frame_count() const override { return expected_frame_count_; }
  std::vector<std::string> files() const override { return paths_; }
  std::string description() const override { return description_; }

 private:
  struct Start {
    int64_t index = 0;
    double seconds = 0.0;
  };

  absl::Status OpenChapter() {
    if (source_ != nullptr) return absl::OkStatus();
    EGOSIEVE_ASSIGN_OR_RETURN(source_, OpenVideoFile(paths_[chapter_], options_));
    return source_->SeekTo(next_index_ - starts_[chapter_].index);
  }

  const std::vector<std::string> paths_;
  const std::string description_;
  const FrameSourceOptions options_;
  const int64_t expected_frame_count_;
  std::vector<Start> starts_ = {{}};  // of the chapters reached so far and of the next one
  std::vector<std::string> warnings_;
  size_t chapter_ = 0;
  std::unique_ptr<FrameSource> source_;  // of chapter_; null until it is read
  int64_t next_index_ = 0;
};

absl::StatusOr<std::unique_ptr<FrameSource>> OpenChapters(std::vector<std::string> paths,
                                                          const std::string& description,
                                                          const FrameSourceOptions& options) {
  int64_t expected = 0;
  std::vector<std::string> readable, warnings;
  absl::Status first_error;
  for (const std::string& path : paths) {
    const auto chapter = OpenVideoFile(path, options);
    if (!chapter.ok()) {
      if (kernels::IsOfTheMachine(chapter.status())) return chapter.status();
      first_error.Update(chapter.status());
      warnings.push_back(absl::StrCat(chapter.status().message(), "; it is left out"));
      continue;
    }
    readable.push_back(path);
    const int64_t count = (*chapter)->expected_frame_count();
    expected = expected < 0 || count < 0 ? -1 : expected + count;
  }
  if (readable.empty()) return first_error;
  return std::make_unique<ChapterSequence>(std::move(readable), description, options, expected,
                                           std::move(warnings));
}

// The run of digits at `begin`, without leading zeros.
std::string_view DigitRun(std::string_view text, size_t begin, size_t* end) {
  *end = begin;
  while (*end < text.size() && absl::ascii_isdigit(text[*end])) ++*end;
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
  const std::string extension = ExtensionOf(input);
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
  if (!options.times.empty()) {
    if (files.are_videos) return TimesOfNoPictures(input);
    EGOSIEVE_ASSIGN_OR_RETURN(files.times_seconds, ReadTimes(options.times, files.paths.size()));
  }
  if (files.are_videos) return OpenChapters(std::move(files.paths), input, options);
  return OpenImageSequence(std::move(files), input, options);
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
    if (absl::ascii_isdigit(a[i]) && absl::ascii_isdigit(b[j])) {
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
  InputFiles files;
  if (HasListExtension(input)) {
    EGOSIEVE_ASSIGN_OR_RETURN(files, ReadFileList(input));
  } else if (HasImageExtension(input)) {
    files.paths = {input};
  } else {
    return OpenVideoFile(input, options);
  }
  return OpenFiles(std::move(files), input, options);
}

}  // namespace egosieve::vision
