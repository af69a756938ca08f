// Videos and streams opened by libavformat, and what their containers say about themselves.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace egosieve::vision {

struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
using Packet = std::unique_ptr<AVPacket, FreePacket>;

// An opened input and the video stream that a player shows: the best one, never a cover picture.
// The packets of all other streams are dropped.
class AvInput {
 public:
  // Null if libavformat finds no video in it. timeout_seconds: how long opening and each read may
  // take; 0: any time, and `path` names a file, whatever characters are in it.
  static std::unique_ptr<AvInput> Open(const std::string& path, int timeout_seconds);

  AVFormatContext* context() const { return context_; }
  AVStream* video() const { return context_->streams[stream_]; }

  // The next packet of the video; AVERROR_EOF at the end, or another error of libavformat's.
  int Read(AVPacket* packet);
  // Goes to a key frame at or before this time, in units of the stream's time base; false if that
  // fails.
  bool SeekTo(int64_t time);

  ~AvInput();
  AvInput(const AvInput&) = delete;
  AvInput& operator=(const AvInput&) = delete;

 private:
  explicit AvInput(int timeout_seconds) : timeout_seconds_(timeout_seconds) {}
  void SetDeadline();
  static int IsLate(void* input);

  const int timeout_seconds_;
  std::chrono::steady_clock::time_point deadline_;
  AVFormatContext* context_ = nullptr;
  int stream_ = -1;
};

// The positions of the frames of a video, read from its packets without decoding.
//
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

// Whether a file ends within a part of its container: a box of MP4, a chunk of AVI or Matroska's
// segment that says how long it is. What follows behind the last whole part does not matter. False
// for other containers.
bool EndsWithinAPart(const std::string& path);

// Whether a file is an MP4 without the table of its samples, as a recording leaves it that was
// never closed.
bool LacksSampleTable(const std::string& path);

// Remarks on videos that are not read as they were recorded or meant to be seen.
//
//   interlaced     each frame holds two half pictures of different times: moving objects have
//                  combed edges
//   HDR            brightness coded for very bright screens (PQ, HLG) is read as ordinary
//                  brightness: pictures have little contrast
//
//   gaps           chapters of one drive with missing time between them, or in an order that
//                  differs from their times: by the creation times of the files, where all have
//                  one and a gap is longer than three seconds
//
// Videos with only ten or twelve bits per colour are read correctly, rounded to eight.
//
// Remarks on a video, or on the chapters of a drive in their order, which are assumed to differ
// only in their times. One sentence each, with the remedy; none for files that are not videos. They
// rely on the metadata of the files.
std::vector<std::string> RemarksOnVideos(const std::vector<std::string>& paths);

}  // namespace egosieve::vision
