// bench_drive: the cost per frame of a long drive, as JSON on stdout.
//
//   bench_drive [--frames=300] [--profiles=paper,paper_full,default,fast,opencv] [--data=DIR]
//               [--megapixels=0] [--threads=0] [--model_points=0]
//       DIR/kitti-residential played back and forth with each profile; steady state is the
//       second half of the frames. paper_full is the paper's profile without its filters 2 and 3,
//       so that the model holds its 4,000 points on a drive this short; opencv is OpenCV's dense
//       flow and its RANSAC fundamental matrix alone. --megapixels scales the pictures.
//   bench_drive --soak [--frames=14500] [--budget=400]
//       one long drive of small frames, alternately synthetic and (if there are data) real: whether
//       time per frame, memory and open files stay constant; fixed work in between shows changes of
//       the machine's own speed.
//
// The exit code is 1 if the output is wrong; times are printed, but not judged.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/drive/drive_measurement.h"
#include "bench/drive/opencv_work.h"
#include "bench/drive/played_source.h"
#include "kernels/base/kept_memory.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/context.h"
#include "vision/labelling/drive_camera.h"

namespace egosieve::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using vision::OnlineSegmenterOptions;

constexpr int64_t kComparedFrames = 6;

struct Profile {
  std::string name;
  OnlineSegmenterOptions options;
  double target_seconds;  // per frame of 1242x375, on two cores
};

std::vector<Profile> Profiles() {
  Profile full{"paper_full", OnlineSegmenterOptions::Paper(), 2.5};
  full.options.learner.novelty_filter = full.options.learner.consistency_filter = false;
  std::vector<Profile> profiles = {{"paper", OnlineSegmenterOptions::Paper(), 2.5},
                                   full,
                                   {"default", OnlineSegmenterOptions::Default(), 0.1},
                                   {"fast", OnlineSegmenterOptions::Fast(), 0.033}};
  return profiles;
}

// A temporary folder, removed with the object.
class ScratchFolder {
 public:
  ScratchFolder()
      : path_((fs::temp_directory_path() / absl::StrCat("bench_drive_", getpid())).string()) {
    fs::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  std::string File(const std::string& name) const { return absl::StrCat(path_, "/", name); }

 private:
  std::string path_;
};

// The masks of a folder, each by the index in `frames` of the picture with the same name. A pixel
// is moving if it is 255, static if 0, else void.
std::map<int64_t, cv::Mat> ReadMasks(const std::string& frames, const std::string& masks) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(frames, error)) {
    names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  std::map<int64_t, cv::Mat> found;
  for (size_t i = 0; i < names.size(); ++i) {
    cv::Mat mask = cv::imread(absl::StrCat(masks, "/", names[i], ".png"), cv::IMREAD_GRAYSCALE);
    if (!mask.empty()) found.emplace(i, std::move(mask));
  }
  return found;
}

// Probabilities of pixels on movers and on the rest.
struct ScoredPixels {
  std::vector<float> movers, rest;

  // The area under the ROC curve: the share of pairs in which the mover has the larger probability,
  // ties by half. Absent without both.
  std::optional<double> Auc() {
    if (movers.empty() || rest.empty()) return std::nullopt;
    std::sort(rest.begin(), rest.end());
    double won = 0.0;
    for (const float p : movers) {
      const auto [low, high] = std::equal_range(rest.begin(), rest.end(), p);
      won += 0.5 * static_cast<double>((low - rest.begin()) + (high - rest.begin()));
    }
    return won / static_cast<double>(movers.size()) / static_cast<double>(rest.size());
  }
};

void Score(const vision::SegmentationMap& map, const cv::Mat& mask, ScoredPixels& scored) {
  for (int row = 0; row < map.grid.rows(); ++row) {
    for (int column = 0; column < map.grid.columns(); ++column) {
      const uint8_t truth = mask.at<uint8_t>(map.grid.y_pixels(row), map.grid.x_pixels(column));
      if (truth != 0 && truth != 255) continue;
      (truth == 255 ? scored.movers : scored.rest)
          .push_back(map.probability[row * map.grid.columns() + column]);
    }
  }
}

Json StageMedians(const DriveMeasurement& drive, size_t begin, size_t end) {
  Json json = Json::object();
  for (int stage = 0; stage < kStages; ++stage) {
    std::vector<double> values;
    for (size_t i = begin; i < end; ++i) values.push_back(drive.frames[i].milliseconds[stage]);
    json[kStageNames[stage]] = Median(std::move(values));
  }
  return json;
}

Json Complaints(const std::vector<std::string>& complaints) {
  const size_t shown = std::min<size_t>(complaints.size(), 5);
  return Json(std::vector<std::string>(complaints.begin(), complaints.begin() + shown));
}

struct Flags {
  bool soak = false;
  int64_t frames = 0;
  int64_t budget = 400;
  double megapixels = 0.0;
  int threads = 0;
  int64_t model_points = 0;
  std::vector<std::string> profiles = {"paper", "paper_full", "default", "fast", "opencv"};
  std::string data;
};

// Sets the camera as segment's first pass does.
absl::Status LearnCamera(PlayedSource& source, OnlineSegmenterOptions& options) {
  vision::FrameLabellerOptions& labeller = options.labeller;
  if (!labeller.WantsCamera()) return absl::OkStatus();
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::DriveCamera camera, vision::LearnDriveCamera(source, {}));
  labeller.focal_ratio = camera.focal_ratio;
  labeller.travel = camera.travel;
  labeller.fixed_pattern = camera.fixed_pattern;
  labeller.windscreen = camera.windscreen;
  labeller.ignored = camera.own_vehicle;
  return absl::OkStatus();
}

// The clip at the requested size.
absl::StatusOr<Clip> ScaledClip(const Clip& clip, double megapixels) {
  if (megapixels == 0.0) return clip;
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat picture, clip.read(0));
  const double scale = std::sqrt(1e6 * megapixels / static_cast<double>(picture.total()));
  return KeptClip(clip, {cvRound(picture.cols * scale), cvRound(picture.rows * scale)});
}

struct ProfileMeasurement {
  DriveMeasurement drive;
  std::optional<double> auc;
  bool same_as_one_thread = false;
};

// path: where the run's files go.
absl::StatusOr<ProfileMeasurement> MeasureProfile(const std::shared_ptr<kernels::Context>& context,
                                                  OnlineSegmenterOptions& options, const Clip& clip,
                                                  const std::map<int64_t, cv::Mat>& masks,
                                                  int64_t count, const std::string& path) {
  ProfileMeasurement result;
  ScoredPixels scored;
  PlayedSource source({clip}, count, count);
  EGOSIEVE_RETURN_IF_ERROR(LearnCamera(source, options));
  EGOSIEVE_ASSIGN_OR_RETURN(
      result.drive,
      MeasureDrive(context, options, source, path, [&](const vision::SegmentedFrame& frame) {
        const auto mask = masks.find(PictureOf(frame.index, clip.size));
        if (mask != masks.end() && frame.index > clip.size) Score(frame.map, mask->second, scored);
      }));
  EGOSIEVE_ASSIGN_OR_RETURN(
      const std::string difference,
      CompareWithOneThread(context, options, source, std::min(count, kComparedFrames), path));
  result.same_as_one_thread = difference.empty();
  if (!difference.empty()) result.drive.complaints.push_back(difference);
  result.auc = scored.Auc();
  return result;
}

Json ProfileJson(const Profile& profile, int64_t count, const ProfileMeasurement& measurement) {
  const DriveMeasurement& drive = measurement.drive;
  const size_t begin = drive.frames.size() / 2;
  return {{"profile", profile.name},
          {"frames", count},
          {"steady_from_frame", begin},
          {"seconds", drive.frames.back().finished_seconds},
          {"processor_seconds", drive.frames.back().processor_seconds},
          {"seconds_per_frame_median", MedianSecondsPerFrame(drive, begin, drive.frames.size())},
          {"seconds_per_frame_target", profile.target_seconds},
          {"processor_seconds_per_frame_median",
           MedianProcessorSecondsPerFrame(drive, begin, drive.frames.size())},
          {"model_points", drive.frames.back().model_size},
          {"features", drive.frames.back().features},
          {"resident_mebibytes", drive.frames.back().resident_mebibytes},
          {"milliseconds_by_stage_median", StageMedians(drive, begin, drive.frames.size())},
          {"auc_of_labelled_frames", measurement.auc ? Json(*measurement.auc) : Json()},
          {"same_bytes_as_one_thread", measurement.same_as_one_thread},
          {"maps_sound", drive.complaints.empty()},
          {"complaints", Complaints(drive.complaints)}};
}

absl::StatusOr<bool> MeasureProfiles(const Flags& flags,
                                     const std::shared_ptr<kernels::Context>& context) {
  const std::string root = flags.data + "/kitti-residential";
  EGOSIEVE_ASSIGN_OR_RETURN(const Clip original, FolderClip(root + "/frames"));
  EGOSIEVE_ASSIGN_OR_RETURN(const Clip clip, ScaledClip(original, flags.megapixels));
  std::map<int64_t, cv::Mat> masks;
  if (flags.megapixels == 0.0) masks = ReadMasks(root + "/frames", root + "/labels");
  const int64_t count = flags.frames > 0 ? flags.frames : 300;
  const ScratchFolder scratch;
  bool sound = true;
  Json results = Json::array();
  const auto is_wanted = [&](const std::string& name) {
    return std::find(flags.profiles.begin(), flags.profiles.end(), name) != flags.profiles.end();
  };
  for (Profile& profile : Profiles()) {
    if (!is_wanted(profile.name)) continue;
    profile.options.labeller.threads = kernels::MaximumThreads();
    if (flags.model_points > 0) profile.options.learner.budget.budget = flags.model_points;
    EGOSIEVE_ASSIGN_OR_RETURN(
        const ProfileMeasurement measurement,
        MeasureProfile(context, profile.options, clip, masks, count, scratch.File(profile.name)));
    sound &= measurement.drive.complaints.empty();
    results.push_back(ProfileJson(profile, count, measurement));
    std::cerr << "bench_drive: " << profile.name << " done\n";
  }
  if (is_wanted("opencv")) {
    EGOSIEVE_ASSIGN_OR_RETURN(OpenCvSeconds seconds, MeasureOpenCv(clip, count));
    results.push_back(
        {{"profile", "opencv"},
         {"frames", count},
         {"seconds_per_frame_median", Median(std::move(seconds.wall))},
         {"processor_seconds_per_frame_median", Median(std::move(seconds.processor))}});
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat picture, clip.read(0));
  std::cout << Json{{"drive", "kitti-residential, back and forth"},
                    {"width_pixels", picture.cols},
                    {"height_pixels", picture.rows},
                    {"threads", kernels::MaximumThreads()},
                    {"profiles", results}}
                   .dump(2)
            << "\n";
  return sound;
}

// Each clip is played for one turn: the median is taken for each clip, then their mean. A common
// median of two clips of different cost would jump between them.
constexpr int64_t kTurn = 250;
constexpr size_t kWorkEvery = 10;  // frames

template <typename MedianOf>
double MeanOfTurns(const DriveMeasurement& drive, size_t begin, size_t end,
                   const MedianOf& median) {
  double sum = 0.0;
  int turns = 0;
  for (size_t turn = begin; turn < end; turn += kTurn, ++turns) {
    sum += median(drive, turn + 1, std::min<size_t>(turn + kTurn, end));
  }
  return sum / turns;
}

Json Snapshot(const DriveMeasurement& drive, size_t begin, size_t end) {
  return {{"frames", absl::StrCat(begin, "-", end)},
          {"seconds_per_frame_median", MeanOfTurns(drive, begin, end, MedianSecondsPerFrame)},
          {"processor_seconds_per_frame_median",
           MeanOfTurns(drive, begin, end, MedianProcessorSecondsPerFrame)},
          {"milliseconds_by_stage_median", StageMedians(drive, begin, end)},
          {"resident_mebibytes", drive.frames[end - 1].resident_mebibytes},
          {"open_files", drive.frames[end - 1].open_files},
          {"model_points", drive.frames[end - 1].model_size}};
}

absl::StatusOr<bool> Soak(const Flags& flags, const std::shared_ptr<kernels::Context>& context) {
  const cv::Size size(416, 128);
  std::vector<Clip> clips;
  EGOSIEVE_ASSIGN_OR_RETURN(clips.emplace_back(), SyntheticClip(40, size));
  if (!flags.data.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(const Clip real,
                              FolderClip(flags.data + "/kitti-residential/frames"));
    EGOSIEVE_ASSIGN_OR_RETURN(clips.emplace_back(), KeptClip(real, size));
  }
  const int64_t count = flags.frames > 0 ? flags.frames : 14500;
  OnlineSegmenterOptions options = OnlineSegmenterOptions::Default();
  options.learner.budget.budget = flags.budget;
  const ScratchFolder scratch;
  PlayedSource source(clips, kTurn, count);
  const size_t begin = std::min<int64_t>(2000, count / 4),
               window = std::min<int64_t>(500, count / 4);
  FixedWork work;
  std::vector<double> early_work, late_work;
  EGOSIEVE_ASSIGN_OR_RETURN(
      const DriveMeasurement drive,
      MeasureDrive(context, options, source, scratch.File("soak"),
                   [&](const vision::SegmentedFrame& frame) {
                     const auto index = static_cast<size_t>(frame.index);
                     if (index % kWorkEvery != 0) return;
                     if (index >= begin && index < begin + window) {
                       early_work.push_back(work.Milliseconds());
                     } else if (index + window >= static_cast<size_t>(count)) {
                       late_work.push_back(work.Milliseconds());
                     }
                   }));
  const size_t frames = drive.frames.size();
  const Json early = Snapshot(drive, begin, begin + window);
  const Json late = Snapshot(drive, frames - window, frames);
  const auto ratio = [&](const char* field) {
    return late[field].get<double>() / early[field].get<double>();
  };
  const double machine = Median(late_work) / Median(early_work);
  std::cout << Json{{"frames", frames},
                    {"pictures", flags.data.empty() ? "synthetic" : "synthetic and real in turn"},
                    {"size", absl::StrCat(size.width, "x", size.height)},
                    {"early", early},
                    {"late", late},
                    {"seconds_ratio", ratio("seconds_per_frame_median")},
                    {"fixed_work_ratio", machine},
                    {"seconds_ratio_to_fixed_work", ratio("seconds_per_frame_median") / machine},
                    {"seconds_ratio_target", 1.1},
                    {"processor_seconds_ratio", ratio("processor_seconds_per_frame_median")},
                    {"resident_ratio", ratio("resident_mebibytes")},
                    {"resident_ratio_target", 1.05},
                    {"maps_sound", drive.complaints.empty()},
                    {"complaints", Complaints(drive.complaints)}}
                   .dump(2)
            << "\n";
  return drive.complaints.empty();
}

absl::StatusOr<bool> Run(const Flags& flags) {
  if (flags.threads > 0) kernels::SetMaximumThreads(flags.threads);
  cv::setNumThreads(kernels::MaximumThreads());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<kernels::Context> context,
                            kernels::OpenContext());
  if (flags.soak) return Soak(flags, context);
  if (flags.data.empty()) {
    return absl::NotFoundError("no data; give their folder with --data or EGOSIEVE_DATA");
  }
  return MeasureProfiles(flags, context);
}

int Main(int argc, char** argv) {
  Flags flags;
  if (const char* data = std::getenv("EGOSIEVE_DATA"); data != nullptr) flags.data = data;
  CLI::App app("What a frame of a long drive costs, as JSON.", "bench_drive");
  app.add_flag("--soak", flags.soak, "One long drive of small frames");
  app.add_option("--frames", flags.frames, "Frames; 0: 300 a profile, 14500 of --soak");
  app.add_option("--budget", flags.budget, "Points of the model of --soak");
  app.add_option("--megapixels", flags.megapixels, "Of the pictures, scaled; 0: as they are");
  app.add_option("--threads", flags.threads, "0: as many as the process may use");
  app.add_option("--model_points", flags.model_points, "Points of the models; 0: the profile's");
  app.add_option("--profiles", flags.profiles, "Those to measure")->delimiter(',');
  app.add_option("--data", flags.data, "Folder of the real drives");
  CLI11_PARSE(app, argc, argv);
  const absl::StatusOr<bool> sound = Run(flags);
  if (!sound.ok()) {
    std::cerr << "bench_drive: " << sound.status().message() << "\n";
    return 2;
  }
  return *sound ? 0 : 1;
}

}  // namespace
}  // namespace egosieve::bench

int main(int argc, char** argv) {
  egosieve::kernels::KeepFreedMemory();
  return egosieve::bench::Main(argc, argv);
}
