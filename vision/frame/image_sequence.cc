#include "vision/frame/image_sequence.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/image_decoding.h"

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

std::string RemarkOnRange(const ValueRange& range) {
  return absl::StrFormat(
      "the pictures use a part of their range; values from %g to %g become 0 to 255, in all of "
      "them alike",
      range.low, range.high);
}

class ImageSequence : public FrameSource {
 public:
  ImageSequence(std::vector<std::string> paths, std::vector<double> times_seconds,
                std::vector<std::string> remarks, const std::optional<ValueRange>& range,
                std::string description, double rate_hz)
      : paths_(std::move(paths)),
        times_seconds_(std::move(times_seconds)),
        remarks_(std::move(remarks)),
        range_(range),
        description_(std::move(description)),
        rate_hz_(rate_hz),
        root_(RootOf(description_, paths_)) {}

  absl::StatusOr<FrameRead> Next() override {
    const int64_t count = static_cast<int64_t>(paths_.size());
    if (next_index_ >= count) return FrameRead(EndOfFrames{count, ""});
    const int64_t index = next_index_;
    absl::StatusOr<DecodedImage> decoded = DecodeImageFile(paths_[index], range_);
    if (kernels::IsOfTheMachine(decoded.status())) return decoded.status();
    ++next_index_;
    if (!decoded.ok()) {
      return FrameRead(DamagedFrame{index, std::string(decoded.status().message())});
    }
    Frame frame;
    frame.index = index;
    frame.time_seconds =
        times_seconds_.empty() ? static_cast<double>(index) / rate_hz_ : times_seconds_[index];
    frame.image = decoded->image;
    frame.is_grey = decoded->is_grey;
    return FrameRead(std::move(frame));
  }

  absl::Status SeekTo(int64_t index) override {
    if (index < 0) return absl::InvalidArgumentError(absl::StrCat("frame index ", index, " < 0"));
    next_index_ = index;
    return absl::OkStatus();
  }

  int64_t next_index() const override { return next_index_; }
  int64_t expected_frame_count() const override { return static_cast<int64_t>(paths_.size()); }
  std::vector<std::string> files() const override { return paths_; }
  std::string image_name(int64_t index) const override {
    if (index < 0 || index >= expected_frame_count()) return FrameSource::image_name(index);
    const fs::path path(paths_[index]);
    return (root_.empty() ? path : path.lexically_relative(root_)).string();
  }
  std::string description() const override { return description_; }
  std::vector<std::string> remarks() const override { return remarks_; }

 private:
  const std::vector<std::string> paths_;
  const std::vector<double> times_seconds_;
  const std::vector<std::string> remarks_;
  const std::optional<ValueRange> range_;
  const std::string description_;
  const double rate_hz_;
  const fs::path root_;
  int64_t next_index_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenImageSequence(std::vector<std::string> paths,
                                                               std::vector<double> times_seconds,
                                                               std::vector<std::string> remarks,
                                                               const std::string& description,
                                                               const FrameSourceOptions& options) {
  std::string first_reason;
  for (const std::string& path : paths) {
    const absl::StatusOr<DecodedImage> decoded = DecodeImageFile(path);
    if (decoded.ok()) {
      EGOSIEVE_ASSIGN_OR_RETURN(const auto range, RangeOfDrive(paths));
      if (range) remarks.push_back(RemarkOnRange(*range));
      return std::unique_ptr<FrameSource>(
          new ImageSequence(std::move(paths), std::move(times_seconds), std::move(remarks), range,
                            description, options.nominal_rate_hz));
    }
    if (kernels::IsOfTheMachine(decoded.status())) return decoded.status();
    if (first_reason.empty()) first_reason = std::string(decoded.status().message());
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "none of the ", paths.size(), " picture files can be read; the first: ", first_reason,
      "; give readable pictures"));
}

}  // namespace egosieve::vision
