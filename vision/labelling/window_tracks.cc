#include "vision/labelling/window_tracks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "vision/frame/ignored_area.h"
#include "vision/labelling/reduced_labels.h"

namespace egosieve::vision {
namespace {

constexpr double kWindowSeconds = 0.6, kLongestWindowSeconds = 2.0;
constexpr double kWindowMotion = 0.025;  // median, of the longer side

}  // namespace

void WindowTracks::Add(const cv::Mat& grey, double seconds) {
  if (tracker_.pictures() == 0) start_seconds_ = seconds;
  size_ = grey.size();
  tracker_.Add(grey);
  const double length = seconds - start_seconds_ + 1e-6;
  is_long_enough_ = length >= kLongestWindowSeconds || (length >= kWindowSeconds && HasMoved()) ||
                    tracker_.pictures() > kLongestWindow;
}

WindowTracks WindowTracks::Of(const KeptTracks& tracks, double start_seconds) {
  WindowTracks window;
  window.tracker_ = CornerTracker::Of(tracks.tracks, tracks.pictures);
  window.start_seconds_ = start_seconds;
  return window;
}

bool WindowTracks::HasMoved() const {
  return tracker_.MedianMotion() >= kWindowMotion * std::max(size_.width, size_.height);
}

KeptTracks WindowTracks::Kept(const cv::Mat1b& ignored) const {
  KeptTracks kept;
  const int last = tracker_.pictures() - 1, views = std::min(kKeptPictures - 1, last);
  if (views < 2) return kept;
  kept.pictures = views + 1;
  for (const CornerTrack& corners : tracker_.tracks()) {
    if (IsIgnored(ignored, size_, corners[0].x, corners[0].y)) continue;
    CornerTrack track;
    for (int view = 0; view <= views; ++view) {
      const auto k = static_cast<size_t>(std::lround(static_cast<double>(view) * last / views));
      if (k >= corners.size()) break;
      track.push_back(corners[k]);
    }
    if (track.size() >= 3) kept.tracks.push_back(std::move(track));
  }
  return kept;
}

TrackWindow EnlargeTracks(const KeptTracks& kept, cv::Size reduced, cv::Size full) {
  TrackWindow window;
  window.pictures = kept.pictures;
  for (const CornerTrack& corners : kept.tracks) {
    std::vector<cv::Point2d>& track = window.tracks.emplace_back();
    for (const cv::Point2f& corner : corners) {
      const PointPair place = EnlargePair({corner.x, corner.y, 0.0, 0.0}, reduced, full);
      track.emplace_back(place.x1, place.y1);
    }
  }
  return window;
}

}  // namespace egosieve::vision
