// The positions of the frames of a video, read from its packets without decoding.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace egosieve::vision {

//   frame k     the packet with the k-th smallest presentation time                        (VI1)
//   key of k    the last key frame not after frame k: decoding from there gives the same frame k
//               as decoding from the beginning                                             (VI2)
//
// A decoder delivers (VI1) only if each packet has a presentation time of its own, is to be shown
// and is complete, and if the first packet is a key frame and the first to be shown. Other videos
// have no index. Cost: the file is read once.
class VideoIndex {
 public:
  // The index of the stream that a player shows; nothing without a reliable one.
  static std::optional<VideoIndex> Read(const std::string& path);

  int64_t size() const { return static_cast<int64_t>(times_.size()); }
  int64_t time(int64_t frame) const { return times_[frame]; }
  int64_t KeyOf(int64_t frame) const {
    return *(std::upper_bound(keys_.begin(), keys_.end(), frame) - 1);
  }
  // The frame with this time; nothing if there is none.
  std::optional<int64_t> FrameAt(int64_t time) const {
    const auto found = std::lower_bound(times_.begin(), times_.end(), time);
    if (found == times_.end() || *found != time) return std::nullopt;
    return found - times_.begin();
  }

 private:
  std::vector<int64_t> times_;  // of each frame, ascending, in units of the stream's time base
  std::vector<int64_t> keys_;   // frames, ascending; the first is 0
};

}  // namespace egosieve::vision
