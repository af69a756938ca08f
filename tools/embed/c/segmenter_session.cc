#include "tools/embed/c/segmenter_session.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gp/io/array_file.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/quiet_libraries.h"
#include "vision/frame/repeated_picture.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kMaximumSide = 16384;
constexpr int64_t kLongestLag = 100;

vision::OnlineSegmenterOptions SegmenterOptions(const SessionOptions& options) {
  auto segmenter = options.profile == Profile::kPaper  ? vision::OnlineSegmenterOptions::Paper()
                   : options.profile == Profile::kFast ? vision::OnlineSegmenterOptions::Fast()
                                                       : vision::OnlineSegmenterOptions::Default();
  segmenter.stride_pixels = options.stride;
  if (options.budget > 0) segmenter.learner.budget.budget = options.budget;
  segmenter.SetSeed(options.seed);
  segmenter.labeller.ignored = options.ignored;
  segmenter.labeller.focal_ratio = options.focal_ratio;
  segmenter.labeller.learns_focal_ratio = true;
  if (options.lag > 0) segmenter.ahead_frames = static_cast<int>(options.lag);
  return segmenter;
}

absl::Status Damaged(const std::string& what) {
  return absl::DataLossError(absl::StrCat("not a segmenter's file: ", what));
}

// The array `name` of `count` elements of type T; -1: any number.
template <typename T>
absl::StatusOr<std::vector<T>> Take(const gp::ArrayMap& arrays, const std::string& name,
                                    int64_t count) {
  const auto found = arrays.find(name);
  if (found == arrays.end()) return Damaged(absl::StrCat("no array \"", name, "\""));
  const auto* elements = std::get_if<std::vector<T>>(&found->second.elements);
  if (elements == nullptr) return Damaged(absl::StrCat("\"", name, "\" is of another type"));
  if (count >= 0 && static_cast<int64_t>(elements->size()) != count) {
    return Damaged(absl::StrCat("\"", name, "\" has ", elements->size(), " elements, not ", count));
  }
  return *elements;
}

gp::NamedArray MaskArray(const cv::Mat1b& mask) {
  if (mask.empty()) return {{0}, std::vector<uint8_t>()};
  return {{mask.rows, mask.cols}, std::vector<uint8_t>(mask.begin(), mask.end())};
}

absl::StatusOr<cv::Mat1b> TakeMask(const gp::ArrayMap& arrays) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto pixels, Take<uint8_t>(arrays, "ignored", -1));
  const std::vector<int64_t>& shape = arrays.at("ignored").shape;
  if (pixels.empty()) return cv::Mat1b();
  if (shape.size() != 2 || shape[0] > kMaximumSide || shape[1] > kMaximumSide) {
    return Damaged("the shape of \"ignored\" is that of no picture");
  }
  cv::Mat1b mask(static_cast<int>(shape[0]), static_cast<int>(shape[1]));
  std::copy(pixels.begin(), pixels.end(), mask.begin());
  return mask;
}

gp::NamedArray PixelsOf(const vision::Frame& frame) {
  const int channels = frame.is_grey ? 1 : 3;
  const int64_t width = int64_t{frame.image.cols} * channels;
  std::vector<uint8_t> pixels;
  pixels.reserve(width * frame.image.rows);
  for (int y = 0; y < frame.image.rows; ++y) {
    const uint8_t* row = frame.image.ptr<uint8_t>(y);
    for (int64_t x = 0; x < width; ++x) pixels.push_back(row[frame.is_grey ? 3 * x : x]);
  }
  return {{frame.image.rows, width}, std::move(pixels)};
}

vision::Frame FrameOf(const kernels::ImageView& image, int64_t index, double time_seconds) {
  vision::QuietLibraries();
  vision::Frame frame;
  frame.index = index;
  frame.time_seconds = time_seconds;
  frame.is_grey = image.channels == 1;
  const cv::Mat pixels(image.height, image.width, frame.is_grey ? CV_8UC1 : CV_8UC3,
                       const_cast<uint8_t*>(image.data), static_cast<size_t>(image.stride_bytes));
  if (frame.is_grey) {
    cv::cvtColor(pixels, frame.image, cv::COLOR_GRAY2BGR);
  } else {
    frame.image = pixels.clone();
  }
  return frame;
}

absl::StatusOr<std::deque<vision::Frame>> TakeFrames(const gp::ArrayMap& arrays) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto indices, Take<int64_t>(arrays, "indices", -1));
  const int64_t count = static_cast<int64_t>(indices.size());
  EGOSIEVE_ASSIGN_OR_RETURN(const auto times, Take<double>(arrays, "times", count));
  std::deque<vision::Frame> frames;
  for (int64_t i = 0; i < count; ++i) {
    const std::string name = absl::StrCat("frame_", i);
    EGOSIEVE_ASSIGN_OR_RETURN(const auto pixels, Take<uint8_t>(arrays, name, -1));
    const std::vector<int64_t>& shape = arrays.at(name).shape;
    EGOSIEVE_ASSIGN_OR_RETURN(const auto grey, Take<int64_t>(arrays, "grey", count));
    const int channels = grey[i] != 0 ? 1 : 3;
    if (shape.size() != 2 || shape[0] < 1 || shape[0] > kMaximumSide || shape[1] < channels ||
        shape[1] % channels != 0 || shape[1] / channels > kMaximumSide) {
      return Damaged(absl::StrCat("the shape of \"", name, "\" is that of no picture"));
    }
    frames.push_back(FrameOf({pixels.data(), static_cast<int>(shape[1] / channels),
                              static_cast<int>(shape[0]), channels, shape[1]},
                             indices[i], times[i]));
  }
  return frames;
}

absl::StatusOr<SessionOptions> TakeOptions(const gp::ArrayMap& arrays) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto numbers, Take<int64_t>(arrays, "options", 4));
  SessionOptions options;
  if (numbers[0] < 0 || numbers[0] > static_cast<int64_t>(Profile::kFast)) {
    return Damaged(absl::StrCat("there is no profile ", numbers[0]));
  }
  options.profile = static_cast<Profile>(numbers[0]);
  options.stride = static_cast<int>(std::clamp<int64_t>(numbers[1], -1, 1 << 20));
  options.budget = numbers[2];
  options.seed = static_cast<uint64_t>(numbers[3]);
  EGOSIEVE_ASSIGN_OR_RETURN(const auto lag, Take<int64_t>(arrays, "lag", 1));
  options.lag = lag[0];
  EGOSIEVE_ASSIGN_OR_RETURN(const auto focal_ratio, Take<double>(arrays, "focal_ratio", 1));
  options.focal_ratio = focal_ratio[0];
  EGOSIEVE_ASSIGN_OR_RETURN(options.ignored, TakeMask(arrays));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  return options;
}

}  // namespace

absl::Status SessionOptions::Validate() const {
  if (stride < 1 || stride > 64) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.stride = %d pixels; it must be 1 to 64", stride));
  }
  if (budget != 0 && (budget < 10 || budget > 20000)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "options.budget = %d points; it must be 10 to 20000, or 0 for the profile's", budget));
  }
  if (lag < 0 || lag > kLongestLag) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.lag = %d frames; it must be 0 to %d", lag, kLongestLag));
  }
  if (!(focal_ratio >= 0.0 && focal_ratio <= 100.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("options.focal_ratio = %g; it must be 0, not known, to 100", focal_ratio));
  }
  return absl::OkStatus();
}

SegmenterSession::SegmenterSession(std::shared_ptr<kernels::Context> context,
                                   const SessionOptions& options,
                                   std::unique_ptr<vision::OnlineSegmenter> segmenter)
    : context_(std::move(context)), options_(options), segmenter_(std::move(segmenter)) {}

absl::StatusOr<std::shared_ptr<SegmenterSession>> SegmenterSession::Create(
    std::shared_ptr<kernels::Context> context, const SessionOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(auto segmenter,
                            vision::OnlineSegmenter::Create(context, SegmenterOptions(options)));
  return std::shared_ptr<SegmenterSession>(
      new SegmenterSession(std::move(context), options, std::move(segmenter)));
}

absl::StatusOr<std::optional<SegmenterSession::Result>> SegmenterSession::Process(
    const kernels::ImageView& image, double time_seconds, bool map_wanted) {
  std::lock_guard lock(mutex_);
  const cv::Size size(image.width, image.height);
  if (!options_.ignored.empty() && options_.ignored.size() != size) {
    return absl::InvalidArgumentError(
        absl::StrFormat("image is %dx%d; options.ignore is %dx%d", size.width, size.height,
                        options_.ignored.cols, options_.ignored.rows));
  }
  if (!waiting_.empty() && waiting_.back().frame.image.size() != size) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "image is %dx%d, the frame before %dx%d; with a lag all frames have one size", size.width,
        size.height, waiting_.back().frame.image.cols, waiting_.back().frame.image.rows));
  }
  const vision::Frame frame = FrameOf(image, next_frame_, time_seconds);
  EGOSIEVE_ASSIGN_OR_RETURN(auto extracted, segmenter_->Extract(frame));
  // From here on the frame counts as taken in, even if the device fails before its map is made.
  ++next_frame_;
  waiting_.push_back({frame, std::move(extracted)});
  if (static_cast<int64_t>(waiting_.size()) <= options_.lag) return std::nullopt;
  return LearnOldest(map_wanted);
}

absl::StatusOr<std::optional<SegmenterSession::Result>> SegmenterSession::Finish(bool map_wanted) {
  std::lock_guard lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  return LearnOldest(map_wanted);
}

int64_t SegmenterSession::FrameCount() {
  std::lock_guard lock(mutex_);
  return next_frame_;
}

std::pair<int64_t, cv::Size> SegmenterSession::WaitingFrames() {
  std::lock_guard lock(mutex_);
  if (waiting_.empty()) return {0, cv::Size()};
  return {waiting_.size(), waiting_.front().frame.image.size()};
}

absl::StatusOr<SegmenterSession::Result> SegmenterSession::LearnOldest(bool map_wanted) {
  const Waiting oldest = std::move(waiting_.front());
  waiting_.pop_front();
  vision::AppendPicture(oldest.frame, recent_);
  while (static_cast<int>(recent_.size()) > segmenter_->options().labeller.HistoryFrames()) {
    recent_.pop_front();
  }
  std::vector<std::shared_ptr<const vision::ExtractedFrame>> ahead;
  for (const Waiting& behind : waiting_) ahead.push_back(behind.extracted);
  EGOSIEVE_ASSIGN_OR_RETURN(auto learnt,
                            segmenter_->Learn(oldest.frame, oldest.extracted, map_wanted, ahead));
  Result result;
  result.record = std::move(learnt.record);
  if (map_wanted) {
    EGOSIEVE_ASSIGN_OR_RETURN(result.map,
                              segmenter_->Infer(oldest.frame, *learnt.posterior, result.record));
  }
  return result;
}

absl::StatusOr<std::string> SegmenterSession::ToBytes() {
  std::lock_guard lock(mutex_);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string checkpoint, segmenter_->Checkpoint());
  gp::ArrayMap arrays;
  arrays["session_version"] = gp::VectorArray<int64_t>({kSessionVersion});
  arrays["options"] =
      gp::VectorArray<int64_t>({static_cast<int64_t>(options_.profile), options_.stride,
                                options_.budget, static_cast<int64_t>(options_.seed)});
  arrays["focal_ratio"] = gp::VectorArray<double>({options_.focal_ratio});
  arrays["lag"] = gp::VectorArray<int64_t>({options_.lag});
  arrays["ignored"] = MaskArray(options_.ignored);
  arrays["waiting"] = gp::VectorArray<int64_t>({static_cast<int64_t>(waiting_.size())});
  arrays["next_frame"] = gp::VectorArray<int64_t>({next_frame_});
  arrays["checkpoint"] = gp::VectorArray<uint8_t>({checkpoint.begin(), checkpoint.end()});
  std::vector<int64_t> indices, grey;
  std::vector<double> times;
  std::vector<vision::Frame> frames(recent_.begin(), recent_.end());
  for (const Waiting& waiting : waiting_) frames.push_back(waiting.frame);
  for (const vision::Frame& frame : frames) {
    arrays[absl::StrCat("frame_", indices.size())] = PixelsOf(frame);
    indices.push_back(frame.index);
    grey.push_back(frame.is_grey);
    times.push_back(frame.time_seconds);
  }
  arrays["indices"] = gp::VectorArray(std::move(indices));
  arrays["grey"] = gp::VectorArray(std::move(grey));
  arrays["times"] = gp::VectorArray(std::move(times));
  return gp::SerializeArrays(arrays);
}

absl::StatusOr<std::shared_ptr<SegmenterSession>> SegmenterSession::FromBytes(
    std::shared_ptr<kernels::Context> context, std::string_view bytes) {
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::ArrayMap arrays, gp::ParseArrays(bytes));
  EGOSIEVE_ASSIGN_OR_RETURN(const auto version, Take<int64_t>(arrays, "session_version", 1));
  if (version[0] != kSessionVersion) {
    return absl::UnimplementedError(absl::StrFormat(
        "the segmenter's file has version %d; this library reads %d", version[0], kSessionVersion));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const SessionOptions options, TakeOptions(arrays));
  EGOSIEVE_ASSIGN_OR_RETURN(const auto next_frame, Take<int64_t>(arrays, "next_frame", 1));
  EGOSIEVE_ASSIGN_OR_RETURN(const auto checkpoint, Take<uint8_t>(arrays, "checkpoint", -1));
  EGOSIEVE_ASSIGN_OR_RETURN(std::deque<vision::Frame> frames, TakeFrames(arrays));
  if (next_frame[0] < 0 || (!frames.empty() && frames.back().index >= next_frame[0])) {
    return Damaged("its frames lie behind its next one");
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const auto waiting, Take<int64_t>(arrays, "waiting", 1));
  const int64_t learnt = static_cast<int64_t>(frames.size()) - waiting[0];
  if (waiting[0] < 0 || waiting[0] > options.lag || learnt < 0) {
    return Damaged(absl::StrFormat("%d of its %d frames wait", waiting[0], frames.size()));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(auto session, Create(std::move(context), options));
  EGOSIEVE_RETURN_IF_ERROR(session->segmenter_->Restore(
      {reinterpret_cast<const char*>(checkpoint.data()), checkpoint.size()},
      std::vector<vision::Frame>(frames.begin(), frames.begin() + learnt)));
  for (auto frame = frames.begin() + learnt; frame != frames.end(); ++frame) {
    EGOSIEVE_ASSIGN_OR_RETURN(auto extracted, session->segmenter_->Extract(*frame));
    session->waiting_.push_back({*frame, std::move(extracted)});
  }
  frames.erase(frames.begin() + learnt, frames.end());
  session->recent_ = std::move(frames);
  session->next_frame_ = next_frame[0];
  return session;
}

}  // namespace egosieve::embed
