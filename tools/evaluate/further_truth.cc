#include "tools/evaluate/further_truth.h"

#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluate/truth_masks.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double MarkedShare(const cv::Mat1b& own, const cv::Mat1f& probability,
                   const kernels::ImageGrid& grid, double threshold) {
  int64_t pixels = 0, marked = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (own(grid.y_pixels(row), grid.x_pixels(column)) == 0) continue;
      ++pixels;
      marked += probability(row, column) >= threshold;
    }
  }
  return pixels > 0 ? static_cast<double>(marked) / static_cast<double>(pixels) : 0.0;
}

absl::Status ScoreMaps(const RunFolder& folder, const FurtherTruth& truth,
                       const FurtherOptions& options, FurtherScores* scores) {
  if (truth.boxes.empty() && truth.own_vehicle.empty()) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(options.boxes.Validate());
  BoxTruth boxes;
  if (!truth.boxes.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(boxes, ReadBoxTruth(truth.boxes));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<ScorableLine> lines, ReadScorableLines(folder));
  BoxScores box_scores(options.boxes);
  double own_sum = 0.0;
  int64_t own_frames = 0;
  for (const auto& [line, of_prior] : lines) {
    if (of_prior && !options.with_prior) continue;
    const auto own_boxes = boxes.find(line.index);
    if (own_boxes == boxes.end() && truth.own_vehicle.empty()) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps,
                              ReadScoredMaps(folder, description, line, options.pixels));
    const kernels::ImageGrid grid = ScoredGrid(line, description, options.pixels);
    if (own_boxes != boxes.end()) box_scores.Add(own_boxes->second, maps.probability, grid);
    if (truth.own_vehicle.empty()) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b own,
                              ReadTruthMask(truth.own_vehicle, cv::Size(grid.width, grid.height)));
    own_sum += MarkedShare(own, maps.probability, grid, options.boxes.threshold);
    ++own_frames;
  }
  if (box_scores.frames() > 0) scores->boxes = std::move(box_scores);
  if (own_frames > 0) scores->own_vehicle_marked = own_sum / static_cast<double>(own_frames);
  return absl::OkStatus();
}

Trajectory Shifted(const Trajectory& trajectory, int frames) {
  Trajectory shifted;
  for (const auto& [frame, pose] : trajectory) shifted[frame + frames] = pose;
  return shifted;
}

absl::Status ScoreTrajectory(const RunFolder& folder, const FurtherTruth& truth,
                             const TrajectoryErrorOptions& options, FurtherScores* scores) {
  std::error_code error;
  const std::string path = folder.File("trajectory.txt");
  if (!fs::exists(path, error)) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(const Trajectory poses, ParseFile(truth.poses, ParseKittiPoses));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<TimedPose> timed,
                            ParseFile(path, ParseTumTrajectory));
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  std::map<int64_t, double> seconds;
  for (const FrameLine& line : lines) seconds[line.index] = line.time_seconds;
  const Trajectory estimate = ByFrame(timed, seconds);
  scores->trajectory = CompareTrajectories(estimate, poses, options);
  for (const int shift : {-1, 1}) {
    TrajectoryErrors errors = CompareTrajectories(estimate, Shifted(poses, shift), options);
    const std::optional<double>& best =
        scores->shifted ? scores->shifted->rotation : scores->trajectory->rotation;
    const double limit = scores->shifted ? 1.0 : 0.5;
    if (!errors.rotation || !best || !(*errors.rotation < limit * *best)) continue;
    scores->shifted = std::move(errors);
    scores->row_shift = shift;
  }
  return absl::OkStatus();
}

Json TrajectoryJson(const TrajectoryErrors& errors) {
  return {{"frames", errors.frames},
          {"rotation_degrees_per_second", OrNull(errors.rotation)},
          {"rotation_neighbours_degrees_per_second", OrNull(errors.rotation_neighbours)},
          {"travelling_pairs", errors.travelling},
          {"direction_degrees", OrNull(errors.direction)}};
}

std::string TrajectoryText(const TrajectoryErrors& errors) {
  const auto number = [](const std::optional<double>& value) {
    return value ? absl::StrFormat("%.3f", *value) : std::string("-");
  };
  return absl::StrCat("rotation ", number(errors.rotation), " degrees a second (neighbours ",
                      number(errors.rotation_neighbours), "), direction of travel ",
                      number(errors.direction), " degrees; medians, ", errors.frames, " frames, ",
                      errors.travelling, " travelling\n");
}

}  // namespace

FurtherTruth FindFurtherTruth(const std::string& input) {
  fs::path path = fs::absolute(input).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  const auto beside = [&](const char* name) {
    std::error_code error;
    const fs::path file = path.parent_path() / name;
    return fs::is_regular_file(file, error) ? file.string() : std::string();
  };
  return {beside("boxes.csv"), beside("poses.txt"), beside("camera.json"),
          beside("own_vehicle.png"), beside("scene.json")};
}

bool FurtherScores::empty() const {
  return !boxes && !trajectory && !focal_error_percent && !own_vehicle_marked && potential.empty();
}

absl::StatusOr<FurtherScores> ScoreFurther(const RunFolder& folder, const FurtherTruth& truth,
                                           const FurtherOptions& options) {
  FurtherScores scores;
  EGOSIEVE_RETURN_IF_ERROR(ScoreMaps(folder, truth, options, &scores));
  EGOSIEVE_ASSIGN_OR_RETURN(
      scores.potential,
      ScorePotential(folder,
                     truth.scene.empty() ? "" : fs::path(truth.scene).parent_path().string(),
                     truth.boxes, options.potential));
  std::optional<CameraTruth> camera;
  if (!truth.camera.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(camera, ParseFile(truth.camera, ParseCamera));
  }
  if (!truth.poses.empty()) {
    TrajectoryErrorOptions trajectory = options.trajectory;
    if (camera && camera->frames_per_second) {
      trajectory.frames_per_second = *camera->frames_per_second;
    }
    EGOSIEVE_RETURN_IF_ERROR(ScoreTrajectory(folder, truth, trajectory, &scores));
  }
  std::error_code error;
  const std::string estimate = folder.File("camera.json");
  if (camera && fs::exists(estimate, error)) {
    EGOSIEVE_ASSIGN_OR_RETURN(const CameraTruth own, ParseFile(estimate, ParseCamera));
    scores.focal_error_percent = FocalErrorPercent(own, *camera);
  }
  return scores;
}

Json ToJson(const FurtherScores& scores) {
  Json json = Json::object();
  if (scores.boxes) json["boxes"] = scores.boxes->ToJson();
  if (scores.trajectory) json["trajectory"] = TrajectoryJson(*scores.trajectory);
  if (scores.shifted) {
    json["trajectory_with_shifted_rows"] = TrajectoryJson(*scores.shifted);
    json["row_shift"] = scores.row_shift;
  }
  json["focal_error_percent"] = OrNull(scores.focal_error_percent);
  json["own_vehicle_marked_share"] = OrNull(scores.own_vehicle_marked);
  if (!scores.potential.empty()) json["potential"] = scores.potential.ToJson();
  return json;
}

std::string ToTable(const FurtherScores& scores) {
  std::string table;
  if (scores.boxes) absl::StrAppend(&table, scores.boxes->ToTable());
  if (scores.trajectory) absl::StrAppend(&table, TrajectoryText(*scores.trajectory));
  if (scores.shifted) {
    absl::StrAppendFormat(&table, "with row k of the poses taken for frame k%+d: %s",
                          scores.row_shift, TrajectoryText(*scores.shifted));
  }
  if (scores.focal_error_percent) {
    absl::StrAppendFormat(&table, "focal length %+.2f percent\n", *scores.focal_error_percent);
  }
  if (scores.own_vehicle_marked) {
    absl::StrAppendFormat(&table, "own vehicle: %.4f of its pixels marked\n",
                          *scores.own_vehicle_marked);
  }
  absl::StrAppend(&table, scores.potential.ToTable());
  return table;
}

}  // namespace egosieve::tools
