// The segmenter within another program: a textured square crosses a background that shifts with the
// camera's motion, and the map finds the square.
//
//   segment [--frames=N] [--device=NAME]
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "egosieve/segmenter.hpp"

namespace {

constexpr int kWidth = 240, kHeight = 160, kSide = 48, kTop = 56;

uint8_t Texture(int x, int y, int seed) {
  uint32_t hash = static_cast<uint32_t>(x / 3) * 73856093u ^
                  static_cast<uint32_t>(y / 3) * 19349663u ^
                  static_cast<uint32_t>(seed) * 83492791u;
  hash = (hash ^ (hash >> 13)) * 0x5bd1e995u;
  return static_cast<uint8_t>((hash ^ (hash >> 15)) % 128);
}

int Left(int t) { return 40 + 7 * t; }

bool InSquare(int x, int y, int t) {
  return x >= Left(t) && x < Left(t) + kSide && y >= kTop && y < kTop + kSide;
}

std::vector<uint8_t> Frame(int t) {
  std::vector<uint8_t> pixels(kWidth * kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      pixels[y * kWidth + x] = InSquare(x, y, t)
                                   ? static_cast<uint8_t>(127 + Texture(x - Left(t), y - kTop, 7))
                                   : Texture(x + 2 * t, y, 1);  // the camera pans
    }
  }
  return pixels;
}

int Segment(int frames, const std::string& device) {
  egosieve::SegmenterOptions options;
  options.device = device;
  egosieve::Segmenter segmenter = egosieve::Segmenter::Create(options).value();
  std::vector<float> probability(kWidth * kHeight);
  double share_inside = 0.0, share_outside = 0.0;
  for (int t = 0; t < frames; ++t) {
    const std::vector<uint8_t> pixels = Frame(t);
    const egosieve::Image image{pixels.data(), kWidth, kHeight, EGOSIEVE_GREY};
    const egosieve::FrameReport report =
        segmenter.Process(image, 0.1 * t, {{probability.data(), kHeight, kWidth}}).value();
    int inside = 0, outside = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool moving = probability[y * kWidth + x] > 0.5f;
        (InSquare(x, y, t) ? inside : outside) += moving;
      }
    }
    share_inside = static_cast<double>(inside) / (kSide * kSide);
    share_outside = static_cast<double>(outside) / (kWidth * kHeight - kSide * kSide);
    std::printf(
        "frame %d: %.0f %% of the square moves, %.0f %% of the rest; model of %lld points%s%s\n", t,
        100.0 * share_inside, 100.0 * share_outside, static_cast<long long>(report.model_size),
        report.learnt ? "" : "; not learnt: ", report.reason.c_str());
  }
  return share_inside > 2.0 * share_outside ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 5;
  std::string device;
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], "--frames=", 9) == 0) {
      frames = std::atoi(argv[i] + 9);
    } else if (std::strncmp(argv[i], "--device=", 9) == 0) {
      device = argv[i] + 9;
    } else {
      std::fprintf(stderr, "usage: segment [--frames=N] [--device=NAME]\n");
      return 2;
    }
  }
  try {
    return Segment(frames, device);
  } catch (const egosieve::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
