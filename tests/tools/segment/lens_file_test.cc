#include "tools/segment/lens_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>

namespace egosieve::tools {
namespace {

std::string Written(const std::string& name, const std::string& text) {
  const std::string path = std::string(std::getenv("TEST_TMPDIR")) + "/" + name;
  std::ofstream(path) << text;
  return path;
}

TEST(LensFile, ColmapsCameras) {
  const std::string text =
      "# Camera list with one line of data per camera:\n"
      "# Number of cameras: 1\n"
      "1 OPENCV 1920 1080 1500.0 1540.0 960 540 0.01 0 0 0\n";
  EXPECT_DOUBLE_EQ(*FocalRatioOfColmap(text), 1520.0 / 1920.0);
  EXPECT_DOUBLE_EQ(*FocalRatioOfColmap("1 SIMPLE_RADIAL 600 800 400 300 400 0.1"), 0.5);
  EXPECT_DOUBLE_EQ(*ReadFocalRatio(Written("cameras.txt", text)), 1520.0 / 1920.0);
}

TEST(LensFile, ARunsCamera) {
  const std::string path =
      Written("camera.json", R"({"focal_pixels": 720, "width": 1440, "height": 400})");
  EXPECT_DOUBLE_EQ(*ReadFocalRatio(path), 0.5);
}

TEST(LensFile, WhatIsWrongIsNamed) {
  const auto message = [](const std::string& text) {
    return std::string(FocalRatioOfColmap(text).status().message());
  };
  EXPECT_THAT(message("# nothing\n"), testing::HasSubstr("no camera"));
  EXPECT_THAT(message("1 MAGIC 10 10 5"), testing::HasSubstr("MAGIC is not known"));
  EXPECT_THAT(message("1 PINHOLE 10 10 5"), testing::HasSubstr("a focal length is missing"));
  EXPECT_THAT(message("1 PINHOLE 10 10 5 -4 5 5"), testing::HasSubstr("must be a positive"));
  EXPECT_THAT(message("1 PINHOLE ten 10 5 4 5 5"), testing::HasSubstr("width and height"));
  const std::string path = Written("bad.json", R"({"width": 1440})");
  EXPECT_THAT(ReadFocalRatio(path).status().message(), testing::HasSubstr("bad.json"));
  EXPECT_EQ(ReadFocalRatio(path + ".gone").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace egosieve::tools
