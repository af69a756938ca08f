// A test of inputs: makes their files and reads their frames.
#pragma once

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <variant>
#include <vector>

#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {

// With an empty folder of its own.
class FolderTest : public ::testing::Test {
 protected:
  void SetUp() override { QuietLibraries(); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  void WriteText(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
  }

  void WriteImage(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite(Path(name), image));
  }

  const std::filesystem::path folder_ = FreshFolder();
};

inline cv::Mat Solid(int type, const cv::Scalar& value) { return cv::Mat(6, 8, type, value); }

inline std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

class InputTest : public FolderTest {
 protected:
  // A picture all of whose pixels have the value.
  void WritePicture(const std::string& name, int value) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    ASSERT_TRUE(cv::imwrite(Path(name), cv::Mat3b(8, 12, cv::Vec3b::all(value))));
  }

  // Grey values 10 k of the frames, from `first` on.
  void WriteVideo(const std::string& name, int first, int count, double rate_hz) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    cv::VideoWriter video(Path(name), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz,
                          cv::Size(64, 32));
    for (int i = first; i < first + count; ++i) video << cv::Mat3b(32, 64, cv::Vec3b::all(10 * i));
  }

  std::string ErrorOf(const std::string& name, const FrameSourceOptions& options = {}) const {
    return std::string(OpenFrameSource(Path(name), options).status().message());
  }

  std::vector<std::string> RemarksOf(const std::string& name) const {
    return Value(OpenFrameSource(Path(name)))->remarks();
  }
};

struct Seen {
  std::vector<int> values;  // of the frames' first pixels, to the next ten
  std::vector<double> times;
  std::vector<std::string> names;
};

inline Seen ReadAll(FrameSource& source) {
  Seen seen;
  while (true) {
    const absl::StatusOr<FrameRead> read = source.Next();
    if (!read.ok() || !std::holds_alternative<Frame>(*read)) return seen;
    const Frame& frame = std::get<Frame>(*read);
    EXPECT_EQ(frame.index, static_cast<int64_t>(seen.values.size()));
    seen.values.push_back((frame.image.at<cv::Vec3b>(4, 4)[0] + 5) / 10 * 10);
    seen.times.push_back(frame.time_seconds);
    seen.names.push_back(source.image_name(frame.index));
  }
}

inline Seen ReadAllOf(const std::string& input, const FrameSourceOptions& options = {}) {
  return ReadAll(*Value(OpenFrameSource(input, options)));
}

}  // namespace egosieve::vision
