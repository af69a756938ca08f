#include "tools/embed/c/segmenter_session.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "gp/io/array_file.h"
#include "tools/embed/c/call.h"
#include "vision/frame/quiet_libraries.h"
#include "vision/frame/repeated_picture.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kMaximumSide = 16384;
constexpr int64_t kLongestLag = 100;

void Validate(const egosieve_segmenter_options& options) {
  Require(options.profile >= EGOSIEVE_PROFILE_DEFAULT && options.profile <= EGOSIEVE_PROFILE_FAST,
          "options.profile = %d; it must be EGOSIEVE_PROFILE_DEFAULT, EGOSIEVE_PROFILE_PAPER or "
          "EGOSIEVE_PROFILE_FAST",
          options.profile);
  Require(options.stride >= 1 && options.stride <= 64,
          "options.stride = %d pixels; it must be 1 to 64", options.stride);
  Require(options.budget == 0 || (options.budget >= 10 && options.budget <= 20000),
          "options.budget = %d points; it must be 10 to 20000, or 0 for the profile's",
          options.budget);
  Require(options.lag >= 0 && options.lag <= kLongestLag,
          "options.lag = %d frames; it must be 0 to %d", options.lag, kLongestLag);
  Require(options.focal_ratio >= 0.0 && options.focal_ratio <= 100.0,
          "options.focal_ratio = %g; it must be 0, not known, to 100", options.focal_ratio);
}

vision::OnlineSegmenterOptions SegmenterOptions(const egosieve_segmenter_options& options,
                                                const cv::Mat1b& ignored) {
  using vision::OnlineSegmenterOptions;
  auto segmenter = options.profile == EGOSIEVE_PROFILE_PAPER  ? OnlineSegmenterOptions::Paper()
                   : options.profile == EGOSIEVE_PROFILE_FAST ? OnlineSegmenterOptions::Fast()
                                                              : OnlineSegmenterOptions::Default();
  segmenter.stride_pixels = options.stride;
  if (options.budget > 0) segmenter.learner.budget.budget = options.budget;
  segmenter.SetSeed(options.seed);
  segmenter.labeller.ignored = ignored;
  segmenter.labeller.focal_ratio = options.focal_ratio;
  if (options.lag > 0) segmenter.ahead_frames = static_cast<int>(options.lag);
  return segmenter;
}

// DataLoss with this text, in StrFormat's manner, unless `sound`.
template <typename... Values>
void RequireSound(bool sound, const absl::FormatSpec<Values...>& text, const Values&... values) {
  if (sound) return;
  Check(absl::DataLossError("not a segmenter's file: " + absl::StrFormat(text, values...)));
}

// The array `name` of `count` elements of type T; -1: any number.
template <typename T>
std::vector<T> TakeArray(const gp::ArrayMap& arrays, const std::string& name, int64_t count = -1) {
  const auto found = arrays.find(name);
  RequireSound(found != arrays.end(), "no array \"%s\"", name);
  const auto* elements = std::get_if<std::vector<T>>(&found->second.elements);
  RequireSound(elements != nullptr, "\"%s\" is of another type", name);
  RequireSound(count < 0 || static_cast<int64_t>(elements->size()) == count,
               "\"%s\" has %d elements, not %d", name, elements->size(), count);
  return *elements;
}

template <typename T>
T TakeNumber(const gp::ArrayMap& arrays, const std::string& name) {
  return TakeArray<T>(arrays, name, 1)[0];
}

// Pixels of one channel or three.
gp::NamedArray ArrayOf(const cv::Mat& picture) {
  const cv::Mat packed = picture.clone();
  return {{packed.rows, int64_t{packed.cols} * packed.channels()},
          std::vector<uint8_t>(packed.data, packed.data + packed.total() * packed.elemSize())};
}

// A view of `pixels`, the array `name`.
vision::ImageView PictureOf(const gp::ArrayMap& arrays, const std::string& name, int channels,
                            const std::vector<uint8_t>& pixels) {
  const std::vector<int64_t>& shape = arrays.at(name).shape;
  RequireSound(shape.size() == 2 && shape[0] >= 1 && shape[0] <= kMaximumSide &&
                   shape[1] >= channels && shape[1] % channels == 0 &&
                   shape[1] / channels <= kMaximumSide,
               "the shape of \"%s\" is that of no picture", name);
  return {pixels.data(), static_cast<int>(shape[1] / channels), static_cast<int>(shape[0]),
          channels, shape[1]};
}

cv::Mat1b TakeMask(const gp::ArrayMap& arrays) {
  const auto pixels = TakeArray<uint8_t>(arrays, "ignored");
  if (pixels.empty()) return cv::Mat1b();
  const vision::ImageView view = PictureOf(arrays, "ignored", 1, pixels);
  return cv::Mat1b(view.height, view.width, const_cast<uint8_t*>(view.data)).clone();
}

vision::Frame FrameOf(const vision::ImageView& image, int64_t index, double time_seconds) {
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

std::deque<vision::Frame> TakeFrames(const gp::ArrayMap& arrays) {
  const auto indices = TakeArray<int64_t>(arrays, "indices");
  const int64_t count = static_cast<int64_t>(indices.size());
  const auto times = TakeArray<double>(arrays, "times", count);
  const auto grey = TakeArray<int64_t>(arrays, "grey", count);
  std::deque<vision::Frame> frames;
  for (int64_t i = 0; i < count; ++i) {
    const std::string name = "frame_" + std::to_string(i);
    const auto pixels = TakeArray<uint8_t>(arrays, name);
    frames.push_back(
        FrameOf(PictureOf(arrays, name, grey[i] != 0 ? 1 : 3, pixels), indices[i], times[i]));
  }
  return frames;
}

}  // namespace

SegmenterSession::SegmenterSession(std::shared_ptr<kernels::Context> context,
                                   const egosieve_segmenter_options& options, cv::Mat1b ignored)
    : options_(options), ignored_(std::move(ignored)) {
  Validate(options_);
  segmenter_ = Take(
      vision::OnlineSegmenter::Create(std::move(context), SegmenterOptions(options_, ignored_)));
}

std::optional<SegmenterSession::Result> SegmenterSession::Process(const vision::ImageView& image,
                                                                  double time_seconds,
                                                                  bool map_wanted) {
  std::lock_guard lock(mutex_);
  const cv::Size size(image.width, image.height);
  Require(ignored_.empty() || ignored_.size() == size, "image is %dx%d; options.ignore is %dx%d",
          size.width, size.height, ignored_.cols, ignored_.rows);
  if (!waiting_.empty()) {
    const cv::Mat& before = waiting_.back().frame.image;
    Require(before.size() == size,
            "image is %dx%d, the frame before %dx%d; with a lag all frames have one size",
            size.width, size.height, before.cols, before.rows);
  }
  const vision::Frame frame = FrameOf(image, next_frame_, time_seconds);
  auto extracted = Take(segmenter_->labeller().Extract(frame));
  // From here on the frame counts as taken in, even if the device fails before its map is made.
  ++next_frame_;
  waiting_.push_back({frame, std::move(extracted)});
  if (static_cast<int64_t>(waiting_.size()) <= options_.lag) return std::nullopt;
  return LearnOldest(map_wanted);
}

std::optional<SegmenterSession::Result> SegmenterSession::Finish(bool map_wanted) {
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

SegmenterSession::Result SegmenterSession::LearnOldest(bool map_wanted) {
  const Waiting oldest = std::move(waiting_.front());
  waiting_.pop_front();
  vision::AppendPicture(oldest.frame, recent_);
  while (static_cast<int>(recent_.size()) > segmenter_->options().labeller.HistoryFrames()) {
    recent_.pop_front();
  }
  std::vector<std::shared_ptr<const vision::ExtractedFrame>> ahead;
  for (const Waiting& behind : waiting_) ahead.push_back(behind.extracted);
  auto learnt = Take(segmenter_->Learn(oldest.frame, oldest.extracted, map_wanted, ahead));
  Result result;
  result.record = std::move(learnt.record);
  if (map_wanted) {
    result.map = Take(segmenter_->Infer(oldest.frame, *learnt.posterior, result.record));
  }
  return result;
}

std::string SegmenterSession::ToBytes() {
  std::lock_guard lock(mutex_);
  const std::string checkpoint = Take(segmenter_->Checkpoint());
  gp::ArrayMap arrays;
  arrays["session_version"] = gp::VectorArray<int64_t>({kSessionVersion});
  arrays["options"] = gp::VectorArray<int64_t>(
      {options_.profile, options_.stride, options_.budget, static_cast<int64_t>(options_.seed)});
  arrays["focal_ratio"] = gp::VectorArray<double>({options_.focal_ratio});
  arrays["lag"] = gp::VectorArray<int64_t>({options_.lag});
  arrays["ignored"] = ignored_.empty() ? gp::VectorArray<uint8_t>({}) : ArrayOf(ignored_);
  arrays["waiting"] = gp::VectorArray<int64_t>({static_cast<int64_t>(waiting_.size())});
  arrays["next_frame"] = gp::VectorArray<int64_t>({next_frame_});
  arrays["checkpoint"] = gp::VectorArray<uint8_t>({checkpoint.begin(), checkpoint.end()});
  std::vector<int64_t> indices, grey;
  std::vector<double> times;
  std::vector<vision::Frame> frames(recent_.begin(), recent_.end());
  for (const Waiting& waiting : waiting_) frames.push_back(waiting.frame);
  for (const vision::Frame& frame : frames) {
    cv::Mat pixels = frame.image;
    if (frame.is_grey) cv::extractChannel(frame.image, pixels, 0);
    arrays["frame_" + std::to_string(indices.size())] = ArrayOf(pixels);
    indices.push_back(frame.index);
    grey.push_back(frame.is_grey);
    times.push_back(frame.time_seconds);
  }
  arrays["indices"] = gp::VectorArray(std::move(indices));
  arrays["grey"] = gp::VectorArray(std::move(grey));
  arrays["times"] = gp::VectorArray(std::move(times));
  return Take(gp::SerializeArrays(arrays));
}

std::shared_ptr<SegmenterSession> SegmenterSession::FromBytes(
    std::shared_ptr<kernels::Context> context, std::string_view bytes) {
  const gp::ArrayMap arrays = Take(gp::ParseArrays(bytes));
  const auto version = TakeNumber<int64_t>(arrays, "session_version");
  if (version != kSessionVersion) {
    Check(absl::UnimplementedError(absl::StrFormat(
        "the segmenter's file has version %d; this library reads %d", version, kSessionVersion)));
  }
  const auto numbers = TakeArray<int64_t>(arrays, "options", 4);
  RequireSound(numbers[0] >= 0 && numbers[0] <= EGOSIEVE_PROFILE_FAST, "there is no profile %d",
               numbers[0]);
  egosieve_segmenter_options options{};
  options.profile = static_cast<egosieve_profile>(numbers[0]);
  options.stride = static_cast<int32_t>(std::clamp<int64_t>(numbers[1], -1, 1 << 20));
  options.budget = numbers[2];
  options.seed = static_cast<uint64_t>(numbers[3]);
  options.lag = TakeNumber<int64_t>(arrays, "lag");
  options.focal_ratio = TakeNumber<double>(arrays, "focal_ratio");
  cv::Mat1b ignored = TakeMask(arrays);
  Validate(options);
  const auto next_frame = TakeNumber<int64_t>(arrays, "next_frame");
  const auto checkpoint = TakeArray<uint8_t>(arrays, "checkpoint");
  std::deque<vision::Frame> frames = TakeFrames(arrays);
  RequireSound(next_frame >= 0 && (frames.empty() || frames.back().index < next_frame),
               "its frames lie behind its next one");
  const auto waiting = TakeNumber<int64_t>(arrays, "waiting");
  const int64_t learnt = static_cast<int64_t>(frames.size()) - waiting;
  RequireSound(waiting >= 0 && waiting <= options.lag && learnt >= 0, "%d of its %d frames wait",
               waiting, frames.size());
  auto session =
      std::make_shared<SegmenterSession>(std::move(context), options, std::move(ignored));
  vision::OnlineSegmenter& segmenter = *session->segmenter_;
  Check(segmenter.Restore({reinterpret_cast<const char*>(checkpoint.data()), checkpoint.size()},
                          {frames.begin(), frames.begin() + learnt}));
  for (auto frame = frames.begin() + learnt; frame != frames.end(); ++frame) {
    session->waiting_.push_back({*frame, Take(segmenter.labeller().Extract(*frame))});
  }
  frames.erase(frames.begin() + learnt, frames.end());
  session->recent_ = std::move(frames);
  session->next_frame_ = next_frame;
  return session;
}

}  // namespace egosieve::embed
