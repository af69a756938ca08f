#include "vision/frame/chapter_sequence.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/video_file.h"

namespace egosieve::vision {
namespace {

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

}  // namespace

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
  return std::unique_ptr<FrameSource>(new ChapterSequence(std::move(readable), description, options,
                                                          expected, std::move(warnings)));
}

}  // namespace egosieve::vision
