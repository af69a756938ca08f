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

double RateOf(int64_t done, double seconds, double first_seconds) {
  if (done > 1 && seconds > first_seconds) {
    return static_cast<double>(done - 1) / (seconds - first_seconds);
  }
  return seconds > 0.0 ? static_cast<double>(done) / seconds : 0.0;
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

double Progress::SecondsToGo(double rate) const {
  return total_ >= 0 && rate > 0.0
             ? static_cast<double>(std::max<int64_t>(total_ - done_, 0)) / rate
             : -1.0;
}

std::string Progress::Text(double rate) const {
  std::string text = absl::StrCat(command_, ": ", done_);
  if (total_ >= 0) {
    absl::StrAppend(&text, "/", std::max(total_, done_));
  }
  absl::StrAppend(&text, " ", unit_, "s, ");
  absl::StrAppend(&text, rate >= 1.0 || rate <= 0.0
                             ? absl::StrFormat("%.1f %ss/s", rate, unit_)
                             : absl::StrFormat("%.2f s/%s", 1.0 / rate, unit_));
  if (const double to_go = SecondsToGo(rate); to_go >= 0.0) {
    absl::StrAppend(&text, ", ", DescribeDuration(to_go), " to go");
  }
  for (const auto& [name, value] : details_) {
    absl::StrAppendFormat(&text, ", %s %.4g", name, value);
  }
  return text;
}

std::string Progress::Json(double rate) const {
  std::string json = absl::StrFormat(
      R"({"command":"%s","done":%d,"total":%d,"frames_per_second":%.4g,"eta_seconds":%.4g)",
      command_, done_, total_, rate, SecondsToGo(rate));
  for (const auto& [name, value] : details_) {
    absl::StrAppendFormat(&json, R"(,"%s":%.6g)", absl::StrReplaceAll(name, {{" ", "_"}}), value);
  }
  return absl::StrCat(json, "}");
}

void Progress::Show(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = RateOf(done_, seconds, first_seconds_);
  if (mode_ == ProgressMode::kJson) {
    stream_ << Json(rate) << std::endl;
  } else if (!terminal_) {
    stream_ << Text(rate) << std::endl;
  } else {
    std::string bar;
    if (total_ > 0) {
      const int filled = static_cast<int>(std::min(done_, total_) * kBarColumns / total_);
      bar =
          absl::StrCat("[", std::string(filled, '#'), std::string(kBarColumns - filled, '.'), "] ");
    }
    // Carriage return, erase the line.
    stream_ << "\r\033[2K" << bar << Text(rate) << std::flush;
  }
  shown_ = true;
  shown_done_ = done_;
  last_shown_ = now;
}

void Progress::Advance(const Details& details) {
  if (++done_ == 1) first_seconds_ = Seconds();
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

void Progress::Finish() {
  if (std::exchange(finished_, true) || mode_ == ProgressMode::kNone) return;
  const bool bar = mode_ == ProgressMode::kAuto && terminal_;
  if (done_ > 0 && done_ != shown_done_ && (bar || shown_)) {
    Show(Clock::now());
  }
  if (bar && shown_) {
    stream_ << std::endl;
  }
}

}  // namespace egosieve::tools
