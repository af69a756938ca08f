#include "tools/segment/run_camera.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/lens_file.h"

namespace egosieve::tools {
namespace {

constexpr char kOwnVehicleShare[] = "own_vehicle_share";
constexpr char kTravelDirection[] = "travel_direction";
constexpr char kTravelConcentration[] = "travel_concentration";
constexpr char kTravelShare[] = "travel_share";
constexpr char kPairs[] = "pairs";
constexpr char kHasFixedPattern[] = "fixed_pattern";
constexpr char kHasWindscreen[] = "windscreen";
constexpr char kCamera[] = "camera.json";

struct CameraImage {
  const char* file;
  cv::Mat1b RunCamera::*image;
};
constexpr CameraImage kImages[] = {{RunFolder::kOwnVehicle, &RunCamera::own_vehicle},
                                   {RunFolder::kFixedPattern, &RunCamera::fixed_pattern},
                                   {RunFolder::kWindscreen, &RunCamera::windscreen}};

// A missing or invalid entry gives the default prior.
vision::TravelPrior ParseTravel(const nlohmann::json& camera) {
  vision::TravelPrior travel;
  const auto direction = camera.find(kTravelDirection);
  if (direction == camera.end() || !direction->is_array() || direction->size() != 3) return {};
  for (int k = 0; k < 3; ++k) {
    if (!(*direction)[k].is_number()) return {};
    travel.direction(k) = (*direction)[k].get<double>();
  }
  travel.concentration = camera.value(kTravelConcentration, 0.0);
  travel.share = camera.value(kTravelShare, 0.0);
  const bool holds = std::abs(travel.direction.norm() - 1.0) < 1e-6 && travel.concentration > 0.0 &&
                     travel.share >= 0.0 && travel.share < 1.0;
  return holds ? travel : vision::TravelPrior();
}

// All numbers are read from the text, so that a resumed run has the same bits as the first one.
absl::StatusOr<RunCamera> Parse(std::string text) {
  RunCamera run;
  EGOSIEVE_ASSIGN_OR_RETURN(run.lens, LensOfJson(text));
  const nlohmann::json json = nlohmann::json::parse(text);
  run.travel = ParseTravel(json);
  run.pair_count = json.value(kPairs, 0);
  run.text = std::move(text);
  return run;
}

}  // namespace

absl::StatusOr<RunCamera> MakeRunCamera(const vision::DriveCamera& camera, cv::Size size,
                                        const LensFile* lens) {
  const bool fits = camera.own_vehicle.size() == size;
  const bool has_windscreen = camera.windscreen.size() == size;
  const double focal = camera.focal_ratio * std::max(size.width, size.height);
  const vision::Lens estimate{focal, focal, 0.5 * size.width, 0.5 * size.height};
  nlohmann::ordered_json json = JsonOfLens(lens != nullptr ? *lens : LensFile{estimate, size});
  json.update(nlohmann::ordered_json{
      {"log_focal_deviation", camera.log_focal_deviation},
      {kPairs, camera.pair_count},
      {kOwnVehicleShare,
       fits ? static_cast<double>(cv::countNonZero(camera.own_vehicle)) / size.area() : 0.0},
      {kTravelDirection,
       {camera.travel.direction(0), camera.travel.direction(1), camera.travel.direction(2)}},
      {kTravelConcentration, camera.travel.concentration},
      {kTravelShare, camera.travel.share},
      {kHasFixedPattern, !camera.fixed_pattern.empty()},
      {kHasWindscreen, has_windscreen}});
  EGOSIEVE_ASSIGN_OR_RETURN(RunCamera run, Parse(json.dump(2) + "\n"));
  if (fits) run.own_vehicle = camera.own_vehicle;
  run.fixed_pattern = camera.fixed_pattern;
  if (has_windscreen) run.windscreen = camera.windscreen;
  return run;
}

namespace {

// prefix: of the files' names.
absl::StatusOr<RunCamera> ReadRunCamera(const std::string& prefix) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::string text, kernels::ReadFile(prefix + kCamera));
  absl::StatusOr<RunCamera> camera = Parse(std::move(text));
  if (!camera.ok()) {
    return absl::DataLossError(absl::StrCat(prefix, kCamera, ": ", camera.status().message(),
                                            "; start the run anew with --overwrite"));
  }
  const nlohmann::json parsed = nlohmann::json::parse(camera->text);
  const bool is_there[] = {parsed.value(kOwnVehicleShare, 0.0) > 0.0,
                           parsed.value(kHasFixedPattern, false),
                           parsed.value(kHasWindscreen, false)};
  for (size_t i = 0; i < std::size(kImages); ++i) {
    if (!is_there[i]) continue;
    EGOSIEVE_ASSIGN_OR_RETURN((*camera).*kImages[i].image,
                              ReadImage(prefix + kImages[i].file, cv::IMREAD_GRAYSCALE));
  }
  return camera;
}

absl::Status WriteRunCamera(const std::string& prefix, const RunCamera& camera) {
  for (const auto& [file, image] : kImages) {
    if ((camera.*image).empty()) continue;
    EGOSIEVE_RETURN_IF_ERROR(WritePng(prefix + file, camera.*image));
  }
  return kernels::WriteFileAtomically(prefix + kCamera, camera.text);
}

}  // namespace

absl::StatusOr<RunCameras> ReadRunCameras(const std::string& directory) {
  EGOSIEVE_ASSIGN_OR_RETURN(const ShotList shots, ReadShots(directory));
  RunCameras cameras;
  cameras.end = shots.end;
  for (const int64_t shot : shots.first_frames) {
    const std::string prefix = RunFolder::CameraPrefix(directory, shot);
    if (!std::filesystem::exists(prefix + kCamera))
      return RunCameras();  // killed while writing them
    EGOSIEVE_ASSIGN_OR_RETURN(cameras.shots[shot], ReadRunCamera(prefix));
  }
  return cameras;
}

absl::Status WriteRunCameras(const std::string& directory, const RunCameras& cameras) {
  ShotList shots;
  shots.end = cameras.end;
  for (const auto& [shot, camera] : cameras.shots) shots.first_frames.push_back(shot);
  if (shots.first_frames.size() > 1) {
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(directory + "/shots"));
  }
  EGOSIEVE_RETURN_IF_ERROR(WriteShots(directory, shots));
  for (const auto& [shot, camera] : cameras.shots) {
    EGOSIEVE_RETURN_IF_ERROR(WriteRunCamera(RunFolder::CameraPrefix(directory, shot), camera));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
