// A drive and its run folder with known maps, for tests of what reads run folders.
//
//   root/frames/NNNNNN.png   noise with a bright disc that moves to the right
//   root/masks/NNNNNN.png    the disc, 255
//   root/run                 a run folder: p as the options say, at grid pixels; frame 0 has the
//   prior (0.5); the frame before the
//                            last was not learnt from
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

struct FakeRunOptions {
  int width_pixels = 96;
  int height_pixels = 64;
  int stride_pixels = 5;
  int frames = 6;
  double inside = 0.9;   // p in the disc
  double outside = 0.2;  // and around it
  double noise = 0.05;   // half the range of what is added to p
};

struct FakeRun {
  std::string frames, masks;
  RunFolder folder;
  RunDescription description;
};

// Replaces what lies at `root`. Fails the test and the process on errors.
FakeRun WriteFakeRun(const std::string& root, const FakeRunOptions& options = {});

// The disc of frame `index`, 0 or 255.
cv::Mat1b FakeMask(const FakeRunOptions& options, int index);

}  // namespace egosieve::tools
