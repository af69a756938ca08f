// Which frames of a run are unreliable, and why.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_DOUBTFUL_FRAMES_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_DOUBTFUL_FRAMES_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/strings/string_view.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

// Why the frame is unreliable; empty if it is reliable.
std::string DoubtOf(const FrameLine& line);

// Turns "only 17 of 300 features" into "only # of # features", to group reasons of one kind.
std::string WithoutNumbers(absl::string_view reason);

class DoubtfulFrames {
 public:
  void Add(const FrameLine& line);

  int64_t count() const { return count_; }
  // "12 of 62 frames are unreliable, most often: ..."; empty if there are none.
  std::string Sentence() const;

 private:
  struct Kind {
    int64_t count = 0;
    std::string first;
  };
  int64_t frames_ = 0, count_ = 0;
  std::map<std::string, Kind> kinds_;  // by WithoutNumbers of the doubt
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_DOUBTFUL_FRAMES_H_
