// Progress of a command, on stderr.
//
//   auto   on a terminal, a bar with rate and remaining time; else one line every five seconds
//   json   one object per line: {"command", "done", "total", "frames_per_second", "eta_seconds",
//          ...}; 0 and -1 while they are not known
//   none   nothing
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
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

// How many per second, over the last minute.
class MovingRate {
 public:
  // `done` are done after `seconds`; both increase.
  void Add(double seconds, int64_t done);
  // 0 until five are done and a second has passed: the first take longer, and a burst is no rate.
  double PerSecond() const;

 private:
  struct Sample {
    double seconds;
    int64_t done;
  };
  std::deque<Sample> samples_ = {{0.0, 0}};  // increasing; the last is the present
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
  // A line of its own beside the progress; nothing where that is not for people.
  void Say(const std::string& line);
  // Time since the beginning.
  double Seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  // Shows the last state, with the time that it took, and ends the bar's line. Later calls do
  // nothing.
  void Finish();

 private:
  void Show(Clock::time_point now);
  std::string Text() const;
  std::string Json() const;
  // -1 if unknown
  double SecondsToGo() const;

  std::string command_, unit_;
  ProgressMode mode_;
  int64_t total_;
  std::ostream& stream_;
  bool terminal_;
  int64_t done_ = 0;
  Details details_;
  bool finished_ = false;
  bool shown_ = false;
  Clock::time_point start_;
  MovingRate rate_;
  Clock::time_point last_shown_;
};

// "12 s", "3 min 05 s", "2 h 07 min"
std::string DescribeDuration(double seconds);

}  // namespace egosieve::tools
