#include "tools/segment/drive_writer.h"

#include <array>
#include <chrono>
#include <ctime>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/segment/resume.h"
#include "tools/segment/trajectory_file.h"

namespace egosieve::tools {
namespace {

std::vector<std::pair<std::string, double>> MakeMilliseconds(
    double read, const vision::StageMilliseconds& stages) {
  return {{"decode", read},
          {"equalization", stages.equalization},
          {"features", stages.features},
          {"matching", stages.matching},
          {"geometry", stages.geometry},
          {"labelling", stages.labelling},
          {"selection", stages.selection},
          {"training", stages.training},
          {"calibration", stages.calibration},
          {"posterior", stages.posterior},
          {"inference", stages.inference}};
}

// Empty if no label is dynamic.
std::vector<std::pair<std::string, double>> MakeShares(
    const std::array<int64_t, vision::kEvidenceTerms>& counts) {
  const auto total = static_cast<double>(std::accumulate(counts.begin(), counts.end(), int64_t{0}));
  std::vector<std::pair<std::string, double>> shares;
  for (int k = 0; total > 0 && k < vision::kEvidenceTerms; ++k) {
    shares.emplace_back(vision::Name(static_cast<vision::EvidenceTerm>(k)),
                        static_cast<double>(counts[k]) / total);
  }
  return shares;
}

// 16-bit images of a map, as RunFolder writes them; views of `map`.
FrameMaps MakeMaps(const vision::SegmentationMap& map) {
  const auto as_image = [&](const std::vector<float>& values) {
    return cv::Mat1f(map.grid.rows(), map.grid.columns(), const_cast<float*>(values.data()));
  };
  return {as_image(map.probability), as_image(map.deviation)};
}

}  // namespace

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc = {};
  gmtime_r(&now, &utc);
  std::array<char, 32> text = {};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

FrameLine MakeLine(const vision::SegmentedFrame& frame) {
  const vision::FrameRecord& record = frame.record;
  FrameLine line;
  line.index = frame.index;
  line.reason = record.reason;
  line.milliseconds = MakeMilliseconds(frame.read_milliseconds, record.milliseconds);
  if (frame.damage.has_value()) {
    line.outcome = FrameLine::Outcome::kFailed;
    return line;
  }
  line.outcome = record.learnt ? FrameLine::Outcome::kLearnt : FrameLine::Outcome::kAnswered;
  line.time_seconds = record.time_seconds;
  line.width_pixels = frame.map.grid.width;
  line.height_pixels = frame.map.grid.height;
  line.features = record.feature_count;
  line.matches = record.match_count;
  line.motion_model = vision::Name(record.motion_model);
  line.inliers = record.inlier_count;
  line.noise_pixels = record.noise_pixels;
  line.labelled_static = record.static_label_count;
  line.labelled_dynamic = record.dynamic_label_count;
  line.frame_gap = record.frame_gap;
  line.decided_by = MakeShares(record.decided_count);
  line.doubt = record.doubt;
  line.step = record.step;
  line.points = record.selection;
  line.model_size = record.model_size;
  line.theta = record.theta;
  line.a = record.squash_a;
  line.b = record.squash_b;
  line.log_likelihood_per_point = record.log_likelihood_per_point;
  line.factor_rebuilt = record.factor_rebuilt;
  line.jitter = record.jitter;
  line.dynamic_share = record.dynamic_share;
  line.expected_overlap = record.expected_overlap;
  line.clamped_variances = record.clamped_variances;
  return line;
}

absl::StatusOr<DriveWriter> DriveWriter::Open(const RunFolder& folder,
                                              const RunDescription& description,
                                              const std::vector<FrameLine>& lines,
                                              std::string device) {
  EGOSIEVE_RETURN_IF_ERROR(folder.WriteDescription(description));
  EGOSIEVE_RETURN_IF_ERROR(folder.OpenLog().status());  // creates it where there is none
  EGOSIEVE_ASSIGN_OR_RETURN(
      LineLog log,
      LineLog::OpenTruncated(folder.File("frames.jsonl"), static_cast<int64_t>(lines.size())));
  DriveWriter writer(folder, description, std::move(log), std::move(device));
  for (const FrameLine& line : lines) {
    writer.Remember(line);
  }
  return writer;
}

absl::Status DriveWriter::AnswerFromBefore(FrameLine& line) const {
  line.time_seconds = last_line_.time_seconds;
  line.model_size = last_line_.model_size;
  line.theta = last_line_.theta;
  line.a = last_line_.a;
  line.b = last_line_.b;
  const FrameLine& before = last_with_map_;
  if (!before.has_map()) return absl::OkStatus();
  for (const MapFile& file : kMapFiles) {
    const absl::StatusOr<std::string> png =
        ReadFile(folder_.FrameFile(file.folder, before.index, file.suffix));
    if (absl::IsNotFound(png.status()) && &file != std::end(kMapFiles) - 1) continue;
    EGOSIEVE_RETURN_IF_ERROR(png.status());
    EGOSIEVE_RETURN_IF_ERROR(
        WriteFileAtomically(folder_.FrameFile(file.folder, line.index, file.suffix), *png));
  }
  line.width_pixels = before.width_pixels;
  line.height_pixels = before.height_pixels;
  line.dynamic_share = before.dynamic_share;
  line.expected_overlap = before.expected_overlap;
  line.map_device = before.map_device;
  return absl::OkStatus();
}

void DriveWriter::Counts::Add(const FrameLine& line) {
  doubtful.Add(line);
  if (line.outcome == FrameLine::Outcome::kFailed) {
    if (failed++ == 0) first_failure = line.reason;
    return;
  }
  ++answered;
  learnt += line.outcome == FrameLine::Outcome::kLearnt;
  baselines.Add(line);
  other_sizes +=
      line.has_map() && (line.width_pixels != grid.width || line.height_pixels != grid.height);
  if (line.outcome == FrameLine::Outcome::kAnswered) last_not_learnt = line.reason;
}

void DriveWriter::Remember(FrameLine line) {
  counts_.Add(line);
  if (line.has_map()) last_with_map_ = line;
  last_line_ = std::move(line);
}

absl::Status DriveWriter::Write(const vision::SegmentedFrame& frame, const std::string& image) {
  const auto start = std::chrono::steady_clock::now();
  FrameLine line = MakeLine(frame);
  line.image = image;
  if (device_ != description_.device) line.map_device = device_;
  if (line.outcome == FrameLine::Outcome::kFailed) {
    EGOSIEVE_RETURN_IF_ERROR(AnswerFromBefore(line));
  } else if (line.has_map()) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        line.saturated_deviations,
        folder_.WriteGridMaps(line.index, MakeMaps(frame.map), description_.deviation_full_scale));
  }
  const std::chrono::duration<double, std::milli> writing =
      std::chrono::steady_clock::now() - start;
  line.milliseconds.emplace_back("writing", writing.count());
  EGOSIEVE_RETURN_IF_ERROR(log_.Append(ToText(line)));
  if (!frame.checkpoint.empty()) {
    EGOSIEVE_RETURN_IF_ERROR(WriteCheckpoint(folder_, frame.index, frame.checkpoint));
  }
  Remember(std::move(line));
  return absl::OkStatus();
}

absl::Status DriveWriter::Finish(const std::string& ended, const std::string& message,
                                 double seconds) {
  description_.ended = ended;
  description_.ended_message = message;
  description_.frames_answered = counts_.answered;
  description_.frames_learnt = counts_.learnt;
  description_.frames_failed = counts_.failed;
  description_.seconds += seconds;
  description_.finished_utc = UtcNow();
  EGOSIEVE_RETURN_IF_ERROR(WriteTrajectory(folder_));
  return folder_.WriteDescription(description_);
}

RunVerdict JudgeRun(const DriveWriter::Counts& counts, const std::string& end_warning) {
  RunVerdict verdict;
  if (counts.other_sizes > 0) {
    verdict.warnings.push_back(
        absl::StrCat(counts.other_sizes, " of ", counts.answered,
                     " frames are of another size than the first; their maps have their size"));
  }
  const std::string too_few = counts.doubtful.TooFewLearnt();
  const bool learnt_nothing = counts.answered > 0 && counts.learnt == 0;
  if (learnt_nothing) {
    verdict.warnings.push_back(
        absl::StrCat("nothing was learnt, so every map is the prior: ", counts.last_not_learnt,
                     "; give frames of a moving camera, two at least"));
  } else if (!too_few.empty()) {
    verdict.warnings.push_back(absl::StrCat(too_few, "; the masks are not to be relied on"));
  } else if (const std::string sparse = counts.baselines.Describe(); !sparse.empty()) {
    verdict.warnings.push_back(sparse);
  }
  bool failed = counts.failed > 0 || learnt_nothing || !too_few.empty();
  if (counts.failed > 0) {
    verdict.warnings.push_back(
        absl::StrCat(counts.failed,
                     " frames could not be read and have the map of the frame "
                     "before: ",
                     counts.first_failure));
  }
  if (!end_warning.empty()) {
    verdict.warnings.push_back(end_warning);
    failed = true;
  }
  if (failed) verdict.code = ExitCode::kFramesFailed;
  return verdict;
}

}  // namespace egosieve::tools
