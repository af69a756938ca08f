// Two run folders of the same drive, compared byte for byte.
#pragma once

#include <string>

namespace egosieve::tools {

// The first difference between two run folders, "" where there is none: the files that they hold,
// and their bytes, but for times (milliseconds in frames.jsonl; seconds, *_utc in run.json).
std::string CompareRuns(const std::string& a, const std::string& b);

}  // namespace egosieve::tools
