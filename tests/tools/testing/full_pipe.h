// A named pipe that is full: a program whose output goes to it waits at its first write, so that it
// cannot end before a test has done what it wants to do.
#ifndef EGOSIEVE_TESTS_TOOLS_TESTING_FULL_PIPE_H_
#define EGOSIEVE_TESTS_TOOLS_TESTING_FULL_PIPE_H_

#include <string>

namespace egosieve::tools {

class FullPipe {
 public:
  // Makes the pipe at `path`, where nothing may be, and fills it.
  explicit FullPipe(const std::string& path);
  ~FullPipe();
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;

  // Takes what is in the pipe, without waiting. What it was filled with is left out. From the first
  // call on the program goes on.
  std::string Empty();

 private:
  int descriptor_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TESTS_TOOLS_TESTING_FULL_PIPE_H_
