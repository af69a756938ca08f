#include "tools/masks/run_length.h"

namespace egosieve::tools {

std::vector<int64_t> RunLengths(const cv::Mat1b& mask) {
  std::vector<int64_t> runs;
  bool is_set = false;
  int64_t length = 0;
  for (int x = 0; x < mask.cols; ++x) {
    for (int y = 0; y < mask.rows; ++y) {
      if ((mask(y, x) != 0) != is_set) {
        runs.push_back(length);
        length = 0;
        is_set = !is_set;
      }
      ++length;
    }
  }
  runs.push_back(length);
  return runs;
}

std::string RunLengthText(const std::vector<int64_t>& runs) {
  std::string text;
  for (size_t i = 0; i < runs.size(); ++i) {
    int64_t x = i > 2 ? runs[i] - runs[i - 2] : runs[i];
    bool more = true;
    while (more) {
      const int64_t bits = x & 31;
      x >>= 5;
      more = (bits & 16) != 0 ? x != -1 : x != 0;
      text.push_back(static_cast<char>(48 + bits + (more ? 32 : 0)));
    }
  }
  return text;
}

}  // namespace egosieve::tools
