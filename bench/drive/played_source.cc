#include "bench/drive/played_source.h"

#include <memory>
#include <opencv2/imgproc.hpp>
#include <variant>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/synthetic/street.h"

namespace egosieve::bench {

int64_t PictureOf(int64_t frame, int64_t size) {
  if (size == 1) return 0;
  const int64_t last = size - 1;
  return last - std::abs(last - frame % (2 * last));
}

absl::StatusOr<vision::FrameRead> PlayedSource::Next() {
  if (next_ >= count_) return vision::FrameRead(vision::EndOfFrames{count_, ""});
  const int64_t index = next_++;
  const int64_t clips = static_cast<int64_t>(clips_.size());
  const int64_t turn = index / turn_;
  const Clip& clip = clips_[turn % clips];
  vision::Frame frame;
  frame.index = index;
  frame.time_seconds = 0.1 * static_cast<double>(index);
  EGOSIEVE_ASSIGN_OR_RETURN(frame.image,
                            clip.read(PictureOf(turn / clips * turn_ + index % turn_, clip.size)));
  return vision::FrameRead(std::move(frame));
}

absl::Status PlayedSource::SeekTo(int64_t index) {
  next_ = index;
  return absl::OkStatus();
}

absl::StatusOr<Clip> FolderClip(const std::string& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<vision::FrameSource> opened,
                            vision::OpenFrameSource(folder, {}));
  const std::shared_ptr<vision::FrameSource> source = std::move(opened);
  Clip clip;
  clip.size = source->expected_frame_count();
  clip.read = [source, folder](int64_t picture) -> absl::StatusOr<cv::Mat> {
    EGOSIEVE_RETURN_IF_ERROR(source->SeekTo(picture));
    EGOSIEVE_ASSIGN_OR_RETURN(vision::FrameRead read, source->Next());
    auto* frame = std::get_if<vision::Frame>(&read);
    if (frame == nullptr) {
      return absl::DataLossError(absl::StrCat("picture ", picture, " of ", folder, " is damaged"));
    }
    return std::move(frame->image);
  };
  return clip;
}

absl::StatusOr<Clip> KeptClip(const Clip& clip, cv::Size size) {
  auto pictures = std::make_shared<std::vector<cv::Mat>>();
  for (int64_t i = 0; i < clip.size; ++i) {
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat picture, clip.read(i));
    cv::resize(picture, pictures->emplace_back(), size, 0.0, 0.0, cv::INTER_AREA);
  }
  return Clip{clip.size, [pictures](int64_t i) { return (*pictures)[i].clone(); }};
}

absl::StatusOr<Clip> SyntheticClip(int64_t count, cv::Size size) {
  vision::ScenarioOptions options;
  options.width_pixels = size.width;
  options.height_pixels = size.height;
  options.frames = static_cast<int>(count);
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::Scenario scenario,
                            vision::MakeScenario("junction", 1, options));
  auto pictures = std::make_shared<std::vector<cv::Mat>>();
  for (int i = 0; i < options.frames; ++i) {
    EGOSIEVE_ASSIGN_OR_RETURN(vision::SyntheticFrame frame, scenario.Render(i));
    pictures->push_back(std::move(frame.image));
  }
  return Clip{count, [pictures](int64_t i) { return (*pictures)[i].clone(); }};
}

}  // namespace egosieve::bench
