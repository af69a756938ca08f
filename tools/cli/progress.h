// Progress of a command, on stderr.
//
//   auto   on a terminal, a bar with rate and remaining time; else one line every five seconds
//   json   one object per line: {"command", "done", "total", "frames_per_second", "eta_seconds",
//          ...}
//   none   nothing
#ifndef EGOSIEVE_TOOLS_CLI_PROGRESS_H_
#define EGOSIEVE_TOOLS_CLI_PROGRESS_H_

#include <chrono>
#include <cstdint>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace egosieve::tools {

enum class ProgressMode { kAuto, kJson, kNone };

// The flag --progress.
struct ProgressFlag {
  ProgressMode mode = ProgressMode::kAuto;
  void AddFlag(CLI::App& app);
};

class Progress {
 public:
  using Clock = std::chrono::steady_clock;
  // Further values to show, by name: "model size" 3999 for example.
  using Details = std::vector<std::pair<std::string, double>>;

  // total: -1 if unknown. It is a hint; `done` may exceed it. unit: what is counted, singular.
  Progress(std::string command, const ProgressFlag& flag, int64_t total,
           std::string unit = "frame");
  // For tests: another stream, which counts as a terminal or not.
  Progress(std::string command, ProgressMode mode, int64_t total, std::ostream& stream,
           bool terminal, std::string unit = "frame");
  ~Progress() { Finish(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // One more is done.
  void Advance(const Details& details = {});
  // The same. False if an interruption was requested (interruption.h).
  bool AdvanceUninterrupted();
  // Time since the beginning.
  double Seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  // Shows the last state and ends the bar's line. Later calls do nothing.
  void Finish();

 private:
  void Show(Clock::time_point now);
  std::string Text(double rate) const;
  std::string Json(double rate) const;
  double SecondsToGo(double rate) const;

  std::string command_, unit_;
  ProgressMode mode_;
  int64_t total_;
  std::ostream& stream_;
  bool terminal_;
  int64_t done_ = 0;
  Details details_;
  bool finished_ = false;
  bool shown_ = false;
  int64_t shown_done_ = 0;
  Clock::time_point start_;
  double first_seconds_ = 0.0;  // when the first was done, since the start
  Clock::time_point last_shown_;
};

// How many per second, of `done` in `seconds`. What comes before the first, such as opening files,
// is left out once there is a second: first_seconds is when the first was done.
double RateOf(int64_t done, double seconds, double first_seconds);

// "12 s", "3 min 05 s", "2 h 07 min"
std::string DescribeDuration(double seconds);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_PROGRESS_H_
