// The sequences of a suite: every folder in it that holds frames and a truth for them.
//
//   frames   frames/, a folder of images
//   truth    scene.json beside masks/ (a synthetic drive), else masks/, else labels/ (masks), else
//            tracks.csv; none in a synthetic drive that is not complete (it has `unfinished`)
//
// A sequence's name is its path below the suite. Its group is the first part of that path, or the
// whole name if there is only one part.
#ifndef EGOSIEVE_TOOLS_SUITE_SEQUENCES_H_
#define EGOSIEVE_TOOLS_SUITE_SEQUENCES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct Sequence {
  std::string name;    // davis/cows
  std::string group;   // davis
  std::string frames;  // paths
  std::string truth;
};

struct SequenceList {
  std::vector<Sequence> sequences;         // by name
  std::vector<std::string> without_truth;  // names of folders with frames but no truth
};

// Searches at most three folders deep. NotFound if there is no such folder or no sequence in it.
absl::StatusOr<SequenceList> FindSequences(const std::string& suite);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_SEQUENCES_H_
