#include "bench/drive/drive_measurement.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/drive_writer.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::bench {
namespace {

using Clock = std::chrono::steady_clock;

double ResidentMebibytes() {
  std::ifstream statm("/proc/self/statm");
  int64_t total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident * sysconf(_SC_PAGESIZE)) / (1 << 20);
}

int64_t OpenFiles() {
  std::error_code error;
  int64_t count = 0;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; entry != end;
       entry.increment(error)) {
    ++count;
  }
  return count;
}

std::string Complaint(const vision::SegmentedFrame& frame) {
  const std::string name = absl::StrCat("frame ", frame.index, ": ");
  if (frame.damage.has_value()) return absl::StrCat(name, *frame.damage);
  const vision::SegmentationMap& map = frame.map;
  if (map.grid.width != frame.frame.image.cols || map.grid.height != frame.frame.image.rows ||
      static_cast<int64_t>(map.probability.size()) != map.grid.size() ||
      map.deviation.size() != map.probability.size()) {
    return absl::StrCat(name, "the map has not its size");
  }
  for (const float p : map.probability) {
    if (!(p >= 0.0f && p <= 1.0f)) return absl::StrCat(name, "a probability of ", p);
  }
  for (const float s : map.deviation) {
    if (!(s >= 0.0f && std::isfinite(s))) return absl::StrCat(name, "a deviation of ", s);
  }
  return "";
}

double ProcessorSeconds() {
  timespec now = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

FrameMeasurement Measure(const tools::FrameLine& line, Clock::time_point start) {
  FrameMeasurement frame;
  frame.processor_seconds = ProcessorSeconds();
  frame.finished_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  frame.resident_mebibytes = ResidentMebibytes();
  frame.open_files = OpenFiles();
  frame.model_size = line.model_size;
  frame.features = line.features;
  frame.learnt = line.outcome == tools::FrameLine::Outcome::kLearnt;
  for (const auto& [stage, value] : line.milliseconds) {
    const auto name = std::find(std::begin(kStageNames), std::end(kStageNames), stage);
    if (name != std::end(kStageNames)) frame.milliseconds[name - std::begin(kStageNames)] = value;
  }
  return frame;
}

absl::Status ReadBack(const tools::RunFolder& folder, int64_t count,
                      std::vector<std::string>& complaints) {
  EGOSIEVE_ASSIGN_OR_RETURN(const tools::RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<tools::FrameLine> lines, folder.ReadLines());
  if (static_cast<int64_t>(lines.size()) != count) {
    complaints.push_back(absl::StrCat(lines.size(), " lines for ", count, " frames"));
  }
  for (const tools::FrameLine& line : lines) {
    const auto maps = folder.ReadGridMaps(line, description, /*with_deviation=*/true);
    if (!maps.ok()) complaints.emplace_back(maps.status().message());
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DriveMeasurement> MeasureDrive(std::shared_ptr<kernels::Context> context,
                                              const vision::OnlineSegmenterOptions& options,
                                              PlayedSource& source, const std::string& directory,
                                              const MapVisitor& visit) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto segmenter,
                            vision::OnlineSegmenter::Create(std::move(context), options));
  EGOSIEVE_ASSIGN_OR_RETURN(const tools::RunFolder folder,
                            tools::RunFolder::Create(directory, /*overwrite=*/false));
  tools::RunDescription description;
  EGOSIEVE_RETURN_IF_ERROR(source.SeekTo(0));
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::FrameRead first, source.Next());
  const cv::Mat& image = std::get<vision::Frame>(first).image;
  description.grid = {image.cols, image.rows, options.stride_pixels};
  EGOSIEVE_ASSIGN_OR_RETURN(auto writer,
                            tools::DriveWriter::Start(folder, description, description.device));
  vision::PipelineOptions pipeline;
  pipeline.overlap = options.labeller.threads > 1;
  pipeline.checkpoint_interval = 25;
  DriveMeasurement drive;
  drive.frames.reserve(source.expected_frame_count());
  const Clock::time_point start = Clock::now();
  EGOSIEVE_ASSIGN_OR_RETURN(
      const vision::PipelineSummary summary,
      vision::RunPipeline(source, *segmenter, pipeline, nullptr,
                          [&](const vision::SegmentedFrame& frame) {
                            EGOSIEVE_RETURN_IF_ERROR(writer.Write(frame));
                            drive.frames.push_back(Measure(writer.last_line(), start));
                            std::string complaint = Complaint(frame);
                            if (!complaint.empty()) drive.complaints.push_back(complaint);
                            if (visit != nullptr) visit(frame);
                            return absl::OkStatus();
                          }));
  EGOSIEVE_RETURN_IF_ERROR(writer.Finish(
      "done", summary.warning, drive.frames.empty() ? 0.0 : drive.frames.back().finished_seconds));
  EGOSIEVE_RETURN_IF_ERROR(ReadBack(folder, source.expected_frame_count(), drive.complaints));
  return drive;
}

absl::StatusOr<std::string> CompareWithOneThread(std::shared_ptr<kernels::Context> context,
                                                 vision::OnlineSegmenterOptions options,
                                                 PlayedSource& source, int64_t count,
                                                 const std::string& directory) {
  options.labeller.threads = 1;
  EGOSIEVE_ASSIGN_OR_RETURN(const auto segmenter,
                            vision::OnlineSegmenter::Create(std::move(context), options));
  EGOSIEVE_ASSIGN_OR_RETURN(const tools::RunFolder whole, tools::RunFolder::Open(directory));
  EGOSIEVE_ASSIGN_OR_RETURN(
      const tools::RunFolder folder,
      tools::RunFolder::Create(absl::StrCat(directory, "-one-thread"), /*overwrite=*/false));
  EGOSIEVE_ASSIGN_OR_RETURN(const tools::RunDescription description, whole.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(auto writer,
                            tools::DriveWriter::Start(folder, description, description.device));
  vision::PipelineOptions pipeline;
  pipeline.overlap = false;
  pipeline.end_frame = count;
  pipeline.checkpoint_interval = 25;
  std::string complaint;
  EGOSIEVE_RETURN_IF_ERROR(
      vision::RunPipeline(
          source, *segmenter, pipeline, nullptr,
          [&](const vision::SegmentedFrame& frame) -> absl::Status {
            EGOSIEVE_RETURN_IF_ERROR(writer.Write(frame));
            for (const char* suffix : {".prob.png", ".std.png"}) {
              EGOSIEVE_ASSIGN_OR_RETURN(const std::string a, tools::ReadFile(folder.FrameFile(
                                                                 "grid", frame.index, suffix)));
              EGOSIEVE_ASSIGN_OR_RETURN(const std::string b, tools::ReadFile(whole.FrameFile(
                                                                 "grid", frame.index, suffix)));
              if (a != b && complaint.empty()) {
                complaint = absl::StrCat("frame ", frame.index, ": one thread gives another map");
              }
            }
            return absl::OkStatus();
          })
          .status());
  return complaint;
}

double Median(std::vector<double> values) {
  return values.empty() ? 0.0 : vision::MedianInPlace(values);
}

namespace {

double MedianStep(const DriveMeasurement& drive, size_t begin, size_t end,
                  double FrameMeasurement::*clock) {
  std::vector<double> steps;
  for (size_t i = std::max<size_t>(begin, 1); i < std::min(end, drive.frames.size()); ++i) {
    steps.push_back(drive.frames[i].*clock - drive.frames[i - 1].*clock);
  }
  return Median(std::move(steps));
}

}  // namespace

double MedianSecondsPerFrame(const DriveMeasurement& drive, size_t begin, size_t end) {
  return MedianStep(drive, begin, end, &FrameMeasurement::finished_seconds);
}

double MedianProcessorSecondsPerFrame(const DriveMeasurement& drive, size_t begin, size_t end) {
  return MedianStep(drive, begin, end, &FrameMeasurement::processor_seconds);
}

}  // namespace egosieve::bench
