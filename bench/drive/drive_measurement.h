// Runs a drive from its frames to its run folder, as `segment` does, and measures it: seconds
// between frames, milliseconds per stage, memory and open files. Also checks the output.
#ifndef EGOSIEVE_BENCH_DRIVE_DRIVE_MEASUREMENT_H_
#define EGOSIEVE_BENCH_DRIVE_DRIVE_MEASUREMENT_H_

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "bench/drive/played_source.h"
#include "kernels/runtime/context.h"
#include "vision/segmentation/segmentation_pipeline.h"

namespace egosieve::bench {

// In the order of a frame's line.
inline constexpr int kStages = 12;
inline constexpr const char* kStageNames[kStages] = {
    "decode",    "equalization", "features",    "matching",  "geometry",  "labelling",
    "selection", "training",     "calibration", "posterior", "inference", "writing"};

// Of fixed size, so that the record of a long drive grows only with its frames.
struct FrameMeasurement {
  double finished_seconds = 0.0;   // since the drive's start
  double processor_seconds = 0.0;  // of all threads, since the drive's start
  double resident_mebibytes = 0.0;
  int64_t open_files = 0;
  int64_t model_size = 0;
  int64_t features = 0;
  bool learnt = false;
  std::array<double, kStages> milliseconds = {};
};

struct DriveMeasurement {
  std::vector<FrameMeasurement> frames;
  std::vector<std::string> complaints;  // about the output; empty if it is sound
};

// Called with each frame, beside the checks; may be null.
using MapVisitor = std::function<void(const vision::SegmentedFrame& frame)>;

// Writes the run folder `directory`, which must not exist. Each map is checked when it is made (it
// exists, has its grid's size, probabilities in [0, 1], deviations finite and not negative), and
// read back from the folder at the end.
absl::StatusOr<DriveMeasurement> MeasureDrive(std::shared_ptr<kernels::Context> context,
                                              const vision::OnlineSegmenterOptions& options,
                                              PlayedSource& source, const std::string& directory,
                                              const MapVisitor& visit);

// Computes the maps of the first `count` frames again, one frame after the other on one thread, and
// compares them with those in `directory` byte by byte. Returns a complaint if they differ.
absl::StatusOr<std::string> CompareWithOneThread(std::shared_ptr<kernels::Context> context,
                                                 vision::OnlineSegmenterOptions options,
                                                 PlayedSource& source, int64_t count,
                                                 const std::string& directory);

double Median(std::vector<double> values);  // 0 if empty
// The median of the seconds between frames begin - 1 and begin, ..., end - 2 and end - 1.
double MedianSecondsPerFrame(const DriveMeasurement& drive, size_t begin, size_t end);
// The same of the processors' time, which other programs disturb less.
double MedianProcessorSecondsPerFrame(const DriveMeasurement& drive, size_t begin, size_t end);

}  // namespace egosieve::bench

#endif  // EGOSIEVE_BENCH_DRIVE_DRIVE_MEASUREMENT_H_
