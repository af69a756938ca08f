// write_fake_run ROOT FRAMES WIDTH HEIGHT: a drive and its run folder, to look at.
#include <cstdlib>

#include "tests/tools/testing/fake_run.h"

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  egosieve::tools::FakeRunOptions options;
  options.frames = std::atoi(argv[2]);
  options.width_pixels = std::atoi(argv[3]);
  options.height_pixels = std::atoi(argv[4]);
  egosieve::tools::WriteFakeRun(argv[1], options);
}
