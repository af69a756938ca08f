#include "tools/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "tools/cli/checks.h"
#include "tools/cli/interruption.h"
#include "tools/cli/standard_streams.h"

namespace egosieve::tools {
namespace {

constexpr std::chrono::milliseconds kBarInterval{100};
constexpr std::chrono::seconds kLineInterval{5};
constexpr int kBarColumns = 24;
constexpr double kRateSeconds = 60.0, kLeastRateSeconds = 1.0;
constexpr int64_t kLeastRateDone = 5;
constexpr double kSampleSeconds = 0.1;  // between two that are kept

}  // namespace

std::string DescribeDuration(double seconds) {
  const int64_t whole = std::llround(seconds);
  if (whole < 60) return absl::StrFormat("%d s", whole);
  if (whole < 3600) return absl::StrFormat("%d min %02d s", whole / 60, whole % 60);
  return absl::StrFormat("%d h %02d min", whole / 3600, whole / 60 % 60);
}

void ProgressFlag::AddFlag(CLI::App& app) {
  AddWords(
      app, "--progress", mode,
      {{"auto", ProgressMode::kAuto}, {"json", ProgressMode::kJson}, {"none", ProgressMode::kNone}},
      "How progress is shown on stderr; auto: a bar on a terminal, else a line every few seconds");
}

void MovingRate::Add(double seconds, int64_t done) {
  const size_t size = samples_.size();
  if (size >= 2 && samples_.back().seconds - samples_[size - 2].seconds < kSampleSeconds) {
    samples_.pop_back();
  }
  samples_.push_back({seconds, done});
  while (samples_.size() > 2 && samples_[1].seconds <= seconds - kRateSeconds) {
    samples_.pop_front();
  }
}

double MovingRate::PerSecond() const {
  const double seconds = samples_.back().seconds - samples_.front().seconds;
  if (samples_.back().done < kLeastRateDone || seconds < kLeastRateSeconds) return 0.0;
  return static_cast<double>(samples_.back().done - samples_.front().done) / seconds;
}

Progress::Progress(std::string command, const ProgressFlag& flag, int64_t total, std::string unit)
    : Progress(std::move(command), flag.mode, total, std::cerr, isatty(StderrDescriptor()) == 1,
               std::move(unit)) {}

Progress::Progress(std::string command, ProgressMode mode, int64_t total, std::ostream& stream,
                   bool terminal, std::string unit)
    : command_(std::move(command)),
      unit_(std::move(unit)),
      mode_(mode),
      total_(total),
      stream_(stream),
      terminal_(terminal),
      start_(Clock::now()),
      last_shown_(start_) {}

double Progress::SecondsToGo() const {
  if (total_ < 0) return -1.0;
  const double rest = static_cast<double>(std::max<int64_t>(total_ - done_, 0));
  const double rate = rate_.PerSecond();
  return rest == 0.0 ? 0.0 : rate > 0.0 ? rest / rate : -1.0;
}

std::string Progress::Text() const {
  std::string text = absl::StrCat(command_, ": ", done_);
  if (total_ >= 0) {
    absl::StrAppend(&text, "/", std::max(total_, done_));
  }
  absl::StrAppend(&text, " ", unit_, "s");
  if (finished_) absl::StrAppend(&text, " in ", DescribeDuration(Seconds()));
  const double rate = finished_ ? static_cast<double>(done_) / Seconds() : rate_.PerSecond();
  if (rate > 0.0) {
    absl::StrAppend(&text, ", ",
                    rate >= 1.0 ? absl::StrFormat("%.1f %ss/s", rate, unit_)
                                : absl::StrFormat("%.2f s/%s", 1.0 / rate, unit_));
  }
  if (finished_) return text;
  if (const double to_go = SecondsToGo(); to_go >= 0.0) {
    absl::StrAppend(&text, ", ", DescribeDuration(to_go), " to go");
  }
  for (const auto& [name, value] : details_) {
    absl::StrAppendFormat(&text, ", %s %.4g", name, value);
  }
  return text;
}

std::string Progress::Json() const {
  std::string json = absl::StrFormat(
      R"({"command":"%s","done":%d,"total":%d,"frames_per_second":%.4g,"eta_seconds":%.4g)",
      command_, done_, total_, rate_.PerSecond(), SecondsToGo());
  for (const auto& [name, value] : details_) {
    absl::StrAppendFormat(&json, R"(,"%s":%.6g)", absl::StrReplaceAll(name, {{" ", "_"}}), value);
  }
  return absl::StrCat(json, "}");
}

void Progress::Show(Clock::time_point now) {
  if (mode_ == ProgressMode::kJson) {
    stream_ << Json() << std::endl;
  } else if (!terminal_) {
    stream_ << Text() << std::endl;
  } else {
    std::string bar;
    if (total_ > 0) {
      const int filled = static_cast<int>(std::min(done_, total_) * kBarColumns / total_);
      bar =
          absl::StrCat("[", std::string(filled, '#'), std::string(kBarColumns - filled, '.'), "] ");
    }
    // Carriage return, erase the line.
    stream_ << "\r\033[2K" << bar << Text() << std::flush;
  }
  shown_ = true;
  last_shown_ = now;
}

void Progress::Advance(const Details& details) {
  rate_.Add(Seconds(), ++done_);
  details_ = details;
  if (mode_ == ProgressMode::kNone) return;
  const Clock::time_point now = Clock::now();
  const bool due = mode_ == ProgressMode::kJson ||
                   now - last_shown_ >=
                       (terminal_ ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval));
  if (due) {
    Show(now);
  }
}

bool Progress::AdvanceUninterrupted() {
  Advance();
  return !InterruptionRequested();
}

void Progress::Say(const std::string& line) {
  if (mode_ != ProgressMode::kAuto) return;
  stream_ << (terminal_ ? "\r\033[2K" : "") << command_ << ": " << line << std::endl;
}

void Progress::Finish() {
  if (std::exchange(finished_, true) || mode_ == ProgressMode::kNone) return;
  if (mode_ == ProgressMode::kJson || done_ == 0) return;  // each has its line
  if (terminal_ || shown_) Show(Clock::now());
  if (terminal_) stream_ << std::endl;
}

}  // namespace egosieve::tools
