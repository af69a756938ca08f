#include "tests/tools/testing/full_pipe.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <climits>

#include "gtest/gtest.h"

namespace egosieve::tools {

// Both ends, so that it opens without waiting and no write finds it without a reader.
FullPipe::FullPipe(const std::string& path)
    : descriptor_(mkfifo(path.c_str(), 0600) == 0
                      ? open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)
                      : -1) {
  EXPECT_GE(descriptor_, 0) << path;
  constexpr std::array<char, PIPE_BUF> kZeros{};
  while (write(descriptor_, kZeros.data(), kZeros.size()) > 0) {
  }
}

FullPipe::~FullPipe() { close(descriptor_); }

std::string FullPipe::Empty() {
  std::string text;
  std::array<char, PIPE_BUF> part;
  ssize_t bytes = 0;
  while ((bytes = read(descriptor_, part.data(), part.size())) > 0) {
    text.append(part.data(), static_cast<size_t>(bytes));
  }
  std::erase(text, '\0');
  return text;
}

}  // namespace egosieve::tools
