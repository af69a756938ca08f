#include "tests/vision/evidence/labelled_clip.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/paper/feature_extractor.h"
#include "vision/paper/feature_matcher.h"

namespace egosieve::vision {
namespace {

constexpr int kThreads = 2;

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
    Track track;
    track.id = id;
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
                           const std::vector<Match>& matches, int64_t& next_id) {
  std::vector<Track> tracks(features.size());
  for (const Match& match : matches) {
    tracks[match.second] = before[match.first].Continued(features.positions[match.second]);
  }
  for (int64_t i = 0; i < features.size(); ++i) {
    if (tracks[i].length > 0) continue;
    tracks[i].id = next_id++;
    tracks[i].length = 1;
    tracks[i].places[0] = features.positions[i];
  }
  return tracks;
}

}  // namespace

absl::StatusOr<LabelledClip> LoadLabelledClip(const std::string& directory, int max_frames) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto tracks, ReadTracks(directory + "/tracks.csv"));
  LabelledClip clip;
  clip.name = directory.substr(directory.find_last_of('/') + 1);
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
                MatchFeatures(previous, features, kThreads), next_id);
    AddLabelled(tracks, index, frame);
    clip.frames.push_back(std::move(frame));
    previous = std::move(features);
  }
  if (clip.frames.empty()) return absl::NotFoundError(directory + ": no frames");
  return clip;
}

double AreaUnderCurve(const std::vector<double>& positives, const std::vector<double>& negatives) {
  if (positives.empty() || negatives.empty()) return 0.5;
  std::vector<std::pair<double, bool>> all;
  for (const double value : positives) all.emplace_back(value, true);
  for (const double value : negatives) all.emplace_back(value, false);
  std::sort(all.begin(), all.end());
  double ranks = 0.0;  // of the positives, from 1, ties averaged
  for (size_t i = 0; i < all.size();) {
    size_t j = i, count = 0;
    for (; j < all.size() && all[j].first == all[i].first; ++j) count += all[j].second ? 1 : 0;
    ranks += static_cast<double>(count) * 0.5 * static_cast<double>(i + 1 + j);
    i = j;
  }
  const double p = static_cast<double>(positives.size()), n = static_cast<double>(negatives.size());
  return (ranks - p * (p + 1) / 2) / (p * n);
}

}  // namespace egosieve::vision
