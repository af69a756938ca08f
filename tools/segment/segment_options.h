// The options of `segment` that say what is computed: one table, from which come the flags, the
// keys of --config, the settings of --set and of [research], what run.json tells, and with it what
// --resume compares.
//
// A profile sets all options; one that is given overrides the profile.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/cli/frame_range.h"
#include "tools/segment/segment_camera.h"
#include "vision/frame/frame_source.h"
#include "vision/segmentation/online_segmenter.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::tools {

// Which frames of a drive are segmented, and when the model is stored.
struct Schedule {
  FrameRange range;
  int64_t skip = 0;               // frames between two that are segmented
  int64_t max_frames = 0;         // 0: no limit
  int64_t checkpoint_every = 25;  // frames; 0: no checkpoints
  vision::FrameSourceOptions source;

  int64_t first_frame() const { return range.from; }
  // Difference between the indices of successive segmented frames.
  int64_t frame_step() const { return skip + 1; }

  vision::PipelineOptions MakePipeline(int threads, int64_t first_frame) const;
};

struct SegmentSettings {
  vision::OnlineSegmenterOptions segmenter;
  CameraSettings camera;
  Schedule schedule;
  std::string features;  // the folder of the dumped features; empty: none
};

struct SegmentOption {
  enum class Kind {
    kFlag,
    kResearch,  // a setting of --set and of the table [research]
    kProfile,   // of the profile alone
  };
  Kind kind;
  std::string name;
  std::string type;  // of the value; empty for a switch
  std::string help;
  CLI::Validator check;
  std::function<void(const std::string& text, SegmentSettings& settings)> set;  // after `check`
  std::function<std::string(const SegmentSettings& settings)> get;
  // Whether run.json tells it, unless it is empty; a continued run then has the same.
  bool is_told = true;
};

const std::vector<SegmentOption>& SegmentOptions();

// The options that are given on the command line or in a file.
class GivenOptions {
 public:
  void AddFlags(CLI::App& app);
  // --profile and these flags alone.
  void AddFlags(CLI::App& app, const std::vector<std::string>& names);
  bool Has(const std::string& name) const;
  // The profile's settings, overridden by the given ones.
  SegmentSettings MakeSettings() const;

 private:
  std::string profile_ = "default";
  std::map<std::string, std::string> given_;  // empty: not given
};

// The value of every option that is told. Runs with the same values have the same maps, whether a
// value was given or came from the profile.
std::map<std::string, std::string> DescribeSettings(const SegmentSettings& settings);

}  // namespace egosieve::tools
