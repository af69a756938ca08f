#include "tests/tools/testing/fake_run.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

void Check(const absl::Status& status) {
  if (!status.ok()) {
    std::fprintf(stderr, "fake run: %s\n", status.ToString().c_str());
    std::abort();
  }
}

// 53 random bits: the same on every library.
double Uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

cv::Mat3b FakeFrame(const FakeRunOptions& options, int index, std::mt19937_64& random) {
  cv::Mat3b frame(options.height_pixels, options.width_pixels);
  for (cv::Vec3b& pixel : frame) {
    const int grey = 60 + static_cast<int>(80 * Uniform(random));
    pixel = cv::Vec3b(grey, grey, grey + 10);
  }
  frame.setTo(cv::Scalar(60, 200, 240), FakeMask(options, index));
  return frame;
}

FrameMaps FakeMaps(const FakeRunOptions& options, const vision::ImageGrid& grid, int index,
                   std::mt19937_64& random) {
  const cv::Mat1b mask = FakeMask(options, index);
  FrameMaps maps;
  maps.probability.create(grid.rows(), grid.columns());
  maps.deviation.create(grid.rows(), grid.columns());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const bool inside = mask(grid.y_pixels(row), grid.x_pixels(column)) != 0;
      const double p = index == 0 ? 0.5
                                  : (inside ? options.inside : options.outside) +
                                        options.noise * (2.0 * Uniform(random) - 1.0);
      maps.probability(row, column) = static_cast<float>(p);
      maps.deviation(row, column) = static_cast<float>(index == 0 ? 1.2 : 0.4);
    }
  }
  return maps;
}

FrameLine FakeRecord(const FakeRunOptions& options, int index) {
  FrameLine line{
      .index = index,
      .time_seconds = index / 25.0,
      .width_pixels = options.width_pixels,
      .height_pixels = options.height_pixels,
      .theta = {0.7, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7, 0.0, -0.7},
      .milliseconds = {{"decode", 4.0}, {"features", 90.0}, {"inference", 120.0 + index % 7}}};
  if (index == 0) {
    line.reason = "the first frame has no pair";
    return line;
  }
  line.model_size = static_cast<int64_t>(4000 * (1.0 - std::exp(-index / 40.0)));
  line.features = 3200;
  line.matches = 1500 + 10 * (index % 11);
  line.motion_model = index % 3 == 0 ? "homography" : "fundamental";
  line.inliers = 1200;
  line.labelled_static = 1300;
  line.labelled_dynamic = 200 + index % 13;
  line.frame_gap = 1;
  line.decided_by = {{"epipolar", 0.75}, {"road", 0.25}};
  line.dynamic_share = 0.1 + 0.05 * std::sin(index / 9.0);
  if (index == options.frames - 2) {
    line.reason = "7 matches; 8 are needed";
    return line;
  }
  line.outcome = FrameLine::Outcome::kLearnt;
  line.points = {1500, 900, 480, 120, 10, 5, 0, 100};
  line.a = 2.0 + 0.1 * std::sin(index / 5.0);
  line.b = -0.3;
  line.log_likelihood_per_point = -0.6 + 0.4 * (1.0 - std::exp(-index / 20.0));
  return line;
}

}  // namespace

cv::Mat1b FakeMask(const FakeRunOptions& options, int index) {
  cv::Mat1b mask(options.height_pixels, options.width_pixels, uint8_t{0});
  const int radius = options.height_pixels / 5;
  const int travel = std::max(options.width_pixels - 2 * radius, 1);
  const cv::Point centre(radius + (index * 7) % travel, options.height_pixels / 2);
  cv::circle(mask, centre, radius, cv::Scalar(255), cv::FILLED);
  return mask;
}

FakeRun WriteFakeRun(const std::string& root, const FakeRunOptions& options) {
  std::filesystem::remove_all(root);
  FakeRun run{root + "/frames", root + "/masks", *RunFolder::Create(root + "/run", false), {}};
  std::filesystem::create_directories(run.frames);
  std::filesystem::create_directories(run.masks);
  run.description.version = "0.0.0-fake";
  run.description.flags = {{"profile", "default"},
                           {"stride", std::to_string(options.stride_pixels)}};
  run.description.device = "a fake device";
  run.description.input = {run.frames, "folder", "fingerprint"};
  run.description.grid = {options.width_pixels, options.height_pixels, options.stride_pixels};
  run.description.started_utc = "2026-01-01T00:00:00Z";
  Check(run.folder.WriteDescription(run.description));

  std::mt19937_64 random(7);
  absl::StatusOr<LineLog> log = run.folder.OpenLog();
  Check(log.status());
  for (int index = 0; index < options.frames; ++index) {
    const std::string name = absl::StrFormat("/%06d.png", index);
    cv::imwrite(run.frames + name, FakeFrame(options, index, random));
    cv::imwrite(run.masks + name, FakeMask(options, index));
    const FrameMaps maps = FakeMaps(options, run.description.grid, index, random);
    Check(run.folder.WriteGridMaps(index, maps, run.description.deviation_full_scale).status());
    Check(log->Append(ToText(FakeRecord(options, index))));
  }
  run.description.ended = "done";
  run.description.frames_answered = options.frames;
  run.description.frames_learnt = std::max(options.frames - 2, 0);
  run.description.seconds = options.frames * 0.3;
  run.description.finished_utc = "2026-01-01T00:00:02Z";
  Check(run.folder.WriteDescription(run.description));
  return run;
}

}  // namespace egosieve::tools
