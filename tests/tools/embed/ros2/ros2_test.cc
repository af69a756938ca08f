// The example of ROS 2, built by its own CMakeLists.txt against a stub of rclcpp: a player publishes
// pictures in bursts and prints what comes out.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/tools/embed/testing/installed_tree.h"

namespace egosieve::embed {
namespace {

constexpr int kWidth = 240, kHeight = 160, kSide = 48, kTop = 56, kPictures = 30, kBurst = 3;

uint8_t Texture(int x, int y, uint32_t seed) {
  uint32_t hash = static_cast<uint32_t>(x / 3) * 73856093u ^
                  static_cast<uint32_t>(y / 3) * 19349663u ^ seed * 83492791u;
  hash = (hash ^ (hash >> 13)) * 0x5bd1e995u;
  return static_cast<uint8_t>((hash ^ (hash >> 15)) % 128);
}

int Left(int t) { return 40 + 3 * t; }

// A textured square crosses a background that shifts with the camera's motion.
void WritePictures(const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  for (int t = 0; t < kPictures; ++t) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool is_inside = x >= Left(t) && x < Left(t) + kSide && y >= kTop && y < kTop + kSide;
        file.put(static_cast<char>(is_inside ? 127 + Texture(x - Left(t), y - kTop, 7)
                                             : Texture(x + t, y, 1)));
      }
    }
  }
}

struct Told {
  std::vector<int> masks;                        // the numbers of their pictures
  std::vector<int> pixels;                       // that move
  std::vector<double> box;                       // centre and size of the last picture's largest
  int pictures = 0, segmented = 0, dropped = 0;  // sums of what the log tells
};

Told Parse(const std::string& output) {
  Told told;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first == "mask") words >> told.masks.emplace_back() >> told.pixels.emplace_back();
    if (first == "objects") {
      double number = 0.0, milliseconds = 0.0, most = 0.0;
      words >> number >> milliseconds;
      for (std::vector<double> box(4); words >> box[0] >> box[1] >> box[2] >> box[3];) {
        if (box[2] * box[3] > most) told.box = box;
        most = std::max(most, box[2] * box[3]);
      }
    }
    int pictures = 0, masks = 0, dropped = 0;
    if (std::sscanf(line.c_str(), "%d pictures, %d masks, %d dropped", &pictures, &masks,
                    &dropped) == 3) {
      told.pictures += pictures;
      told.segmented += masks;
      told.dropped += dropped;
    }
  }
  return told;
}

// The folder of the installed node and of the pictures, made once a process; empty where it cannot
// be built.
const std::string& Node() {
  static const std::string folder = [] {
    const std::string stub = std::filesystem::absolute("tests/tools/embed/ros2/stub").string();
    std::string packages;
    for (const char* const name : {"ament_cmake", "rclcpp", "sensor_msgs", "vision_msgs"}) {
      packages += std::string(" -D") + name + "_DIR='" + stub + "/cmake'";
    }
    const std::string build = NewFolder("ros2");
    const CommandOutcome built = RunClean(
        build, "cmake -S '" + InstalledTree() + "/share/egosieve/examples/ros2' -B . " + packages +
                   " -DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror' -DCMAKE_PREFIX_PATH='" +
                   InstalledTree() +
                   "' && cmake --build . && cmake --install . --prefix installed");
    EXPECT_EQ(built.code, 0) << built.output;
    WritePictures(build + "/pictures");
    return built.code == 0 ? build : "";
  }();
  return folder;
}

Told Play(int burst) {
  const CommandOutcome played = RunClean(
      Node(),
      "timeout 120 installed/lib/egosieve_ros2/segmenter_node --ros-args -p profile:=default",
      "PLAY=pictures WIDTH=240 HEIGHT=160 FOCAL=200 BURST=" + std::to_string(burst));
  EXPECT_EQ(played.code, 0) << played.output;
  return Parse(played.output);
}

class Ros2 : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasProgram("cmake")) GTEST_SKIP() << "there is no cmake to build with";
    if (IsInstrumented()) GTEST_SKIP() << "plain programs cannot load libraries with a sanitizer";
    const char* const device = std::getenv("EGOSIEVE_DEVICE");
    if (device != nullptr && std::string(device) == "reference") {
      GTEST_SKIP() << "the reference is too slow for a live camera";
    }
    ASSERT_NE(Node(), "");
  }
};

TEST_F(Ros2, TheNewestPictureComesFirst) {
  const Told told = Play(kBurst);
  // Each burst's last picture has a mask, and of the others none after a newer one.
  for (int last = kBurst - 1; last < kPictures; last += kBurst) {
    EXPECT_EQ(std::count(told.masks.begin(), told.masks.end(), last), 1) << last;
  }
  EXPECT_TRUE(std::is_sorted(told.masks.begin(), told.masks.end()));
  EXPECT_EQ(told.pictures, kPictures);
  EXPECT_EQ(told.segmented, static_cast<int>(told.masks.size()));
  EXPECT_EQ(told.segmented + told.dropped, kPictures);
  EXPECT_GT(told.dropped, 0);
}

// One picture after the other, so that the node learns from all of them.
TEST_F(Ros2, MasksAndObjectsAreOfWhatMoves) {
  const Told told = Play(1);
  ASSERT_EQ(told.masks.size(), static_cast<size_t>(kPictures));
  EXPECT_EQ(told.dropped, 0);
  EXPECT_EQ(told.pixels.front(), 0);  // nothing comes before it
  EXPECT_NEAR(told.pixels.back(), kSide * kSide, kSide * kSide / 4);
  ASSERT_EQ(told.box.size(), 4u);
  EXPECT_NEAR(told.box[0], Left(kPictures - 1) + kSide / 2, kSide / 3);
  EXPECT_NEAR(told.box[1], kTop + kSide / 2, kSide / 3);
  EXPECT_NEAR(told.box[2], kSide, kSide / 3);
  EXPECT_NEAR(told.box[3], kSide, kSide / 3);
}

}  // namespace
}  // namespace egosieve::embed
