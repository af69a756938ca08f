// Clips with labelled point tracks (KT3DMoSeg; see the data's README): the clip's own features
// tracked by the library, from which motion is estimated, and beside them the labelled tracks, at
// which evidence is scored.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tests/testing/area_under_curve.h"
#include "tests/testing/status.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/paper/feature_extractor.h"
#include "vision/paper/feature_matcher.h"
#include "vision/paper/ransac.h"
#include "vision/tracking/track.h"

namespace egosieve::vision {
namespace {

struct LabelledClip {
  struct Frame {
    std::vector<Track> features;  // SIFT and corners, chained by their matches
    std::vector<Track> labelled;  // ids as in the file
    std::vector<bool> moving;     // one a labelled track
  };
  cv::Size size;
  std::vector<Frame> frames;
};

struct LabelledTrack {
  int label = 0;
  std::map<int, cv::Point2f> places;  // by frame
};

absl::StatusOr<std::map<int, LabelledTrack>> ReadTracks(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return absl::NotFoundError(absl::StrCat("cannot read ", path));
  std::map<int, LabelledTrack> tracks;
  while (std::getline(file, line)) {
    int track = 0, label = 0, frame = 0;
    float x = 0.0F, y = 0.0F;
    if (std::sscanf(line.c_str(), "%d,%d,%d,%f,%f", &track, &label, &frame, &x, &y) != 5) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": bad line ", line));
    }
    tracks[track].label = label;
    tracks[track].places[frame] = {x, y};
  }
  return tracks;
}

void AddLabelled(const std::map<int, LabelledTrack>& tracks, int index,
                 LabelledClip::Frame& frame) {
  for (const auto& [id, labelled] : tracks) {
    Track track{.id = id};
    for (int k = 0; k < kTrackHistory; ++k) {
      const auto place = labelled.places.find(index - k);
      if (place == labelled.places.end()) break;
      track.places[track.length++] = place->second;
    }
    if (track.length == 0) continue;
    if (track.length > 1) track.parent_id = id;
    frame.labelled.push_back(track);
    frame.moving.push_back(labelled.label != 1);
  }
}

// One track per feature: that of its match, or a new one.
std::vector<Track> Chained(const std::vector<Track>& before, const FeatureSet& features,
                           const std::vector<cv::DMatch>& matches, int64_t& next_id) {
  std::vector<Track> tracks(features.size());
  for (const cv::DMatch& match : matches) {
    tracks[match.trainIdx] = before[match.queryIdx].Continued(features.positions[match.trainIdx]);
  }
  for (int64_t i = 0; i < features.size(); ++i) {
    if (tracks[i].length > 0) continue;
    tracks[i].id = next_id++;
    tracks[i].length = 1;
    tracks[i].places[0] = features.positions[i];
  }
  return tracks;
}

// directory/{frames/%06d.png, tracks.csv}; the first `max_frames`.
absl::StatusOr<LabelledClip> LoadLabelledClip(const std::string& directory, int max_frames) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto tracks, ReadTracks(directory + "/tracks.csv"));
  LabelledClip clip;
  FeatureSet previous;
  int64_t next_id = 0;
  for (int index = 1; index <= max_frames; ++index) {
    char name[32];
    std::snprintf(name, sizeof(name), "/frames/%06d.png", index);
    const cv::Mat grey = cv::imread(directory + name, cv::IMREAD_GRAYSCALE);
    if (grey.empty()) break;
    clip.size = grey.size();
    EGOSIEVE_ASSIGN_OR_RETURN(FeatureSet features, ExtractFeatures(grey));
    LabelledClip::Frame frame;
    frame.features =
        Chained(clip.frames.empty() ? std::vector<Track>() : clip.frames.back().features, features,
                MatchFeatures(previous, features), next_id);
    AddLabelled(tracks, index, frame);
    clip.frames.push_back(std::move(frame));
    previous = std::move(features);
  }
  if (clip.frames.empty()) return absl::NotFoundError(directory + ": no frames");
  return clip;
}

// One a frame, from the clip's own features; identity and kNone for the first `gap` frames.
struct ClipMotion {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
};

absl::StatusOr<std::vector<ClipMotion>> FundamentalsOf(const LabelledClip& clip, int gap) {
  std::vector<ClipMotion> motions(clip.frames.size());
  for (size_t t = gap; t < clip.frames.size(); ++t) {
    std::vector<PointPair> pairs;
    for (const Track& track : clip.frames[t].features) {
      if (!track.Reaches(gap)) continue;
      const cv::Point2f before = track.places[gap], now = track.places[0];
      pairs.push_back({before.x, before.y, now.x, now.y});
    }
    motions[t].kind = MotionModelKind::kFundamental;
    EGOSIEVE_ASSIGN_OR_RETURN(motions[t].matrix, EstimateFundamental(pairs, 1.0, /*seed=*/1));
  }
  return motions;
}

constexpr int64_t kLabelledIds = int64_t{1} << 40;  // beyond those of the tracker

// Expected, ten bins (ECE).
double CalibrationError(const std::vector<double>& probabilities,
                        const std::vector<bool>& is_mover) {
  constexpr int kBins = 10;
  std::array<double, kBins> surplus{};
  for (size_t i = 0; i < probabilities.size(); ++i) {
    const int bin = std::min(kBins - 1, static_cast<int>(probabilities[i] * kBins));
    surplus[bin] += probabilities[i] - (is_mover[i] ? 1.0 : 0.0);
  }
  double error = 0.0;
  for (const double bin : surplus) error += std::abs(bin);
  return error / static_cast<double>(probabilities.size());
}

struct ClipScore {
  double auc = 0.5;  // of the probability, over all points of all frames
  double calibration_error = 0.0;
};

// Labelled tracks take no part in estimating. Scored are the points that reach `gap` frames back.
absl::StatusOr<ClipScore> ScoreClip(const LabelledClip& clip,
                                    const std::vector<ClipMotion>& motions, int gap,
                                    const EvidenceOptions& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceAccumulator accumulator, EvidenceAccumulator::Create(options));
  std::vector<double> probabilities;
  std::vector<bool> is_mover;
  for (size_t t = 0; t < clip.frames.size(); ++t) {
    const LabelledClip::Frame& frame = clip.frames[t];
    EvidenceFrame input{.index = static_cast<int64_t>(t),
                        .gap = gap,
                        .size = clip.size,
                        .motion_model = motions[t].kind,
                        .motion_matrix = motions[t].matrix};
    for (const Track& track : frame.features) input.points.push_back(PointOfTrack(track, gap));
    for (const Track& track : frame.labelled) {
      EvidencePoint point = PointOfTrack(track, gap);
      point.track_id += kLabelledIds;
      if (point.parent_id >= 0) point.parent_id += kLabelledIds;
      point.estimates = false;
      input.points.push_back(point);
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const EvidenceResult result, accumulator.Add(input));
    for (size_t i = 0; i < frame.labelled.size(); ++i) {
      if (!frame.labelled[i].Reaches(gap)) continue;
      probabilities.push_back(result.points[frame.features.size() + i].probability);
      is_mover.push_back(frame.moving[i]);
    }
  }
  return ClipScore{AreaUnderCurve(probabilities, is_mover),
                   CalibrationError(probabilities, is_mover)};
}

EvidenceOptions EpipolarAlone() {
  EvidenceOptions options;
  options.negative_depth = options.accumulation = false;
  return options;
}

// At the labelled tracks of three driving clips (KT3DMoSeg): movers against the rest. And the guess
// of the focal length must not matter.
TEST(LabelledClips, AllEvidenceTellsMoversFromTheRest) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name the folder of the test data";
  constexpr int kGap = 2, kFrames = 11;
  double mean = 0.0, mean_epipolar = 0.0, calibration = 0.0;
  for (const char* name : {"Seq005_Clip01", "Seq013_Clip02", "Seq028_Clip01"}) {
    const auto clip = Value(LoadLabelledClip(std::string(data) + "/kt3dmoseg/" + name, kFrames));
    const auto motions = Value(FundamentalsOf(clip, kGap));
    const auto all = Value(ScoreClip(clip, motions, kGap, EvidenceOptions()));
    const auto epipolar = Value(ScoreClip(clip, motions, kGap, EpipolarAlone()));
    EXPECT_GT(all.auc, epipolar.auc) << name;
    EXPECT_GT(all.auc, 0.95) << name;
    mean += all.auc / 3;
    mean_epipolar += epipolar.auc / 3;
    calibration += all.calibration_error / 3;
    for (const double share : {0.58, 1.2}) {  // 0.58: the true one
      const EvidenceOptions options{.focal_pixels = share * clip.size.width};
      EXPECT_NEAR(ScoreClip(clip, motions, kGap, options)->auc, all.auc, 0.01)
          << name << " " << share;
    }
  }
  RecordProperty("all", std::to_string(mean));
  RecordProperty("epipolar", std::to_string(mean_epipolar));
  EXPECT_GT(mean, 0.98);
  EXPECT_LT(calibration, 0.06);
}

}  // namespace
}  // namespace egosieve::vision
