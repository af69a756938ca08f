#include "vision/frame/video_index.h"

#include <memory>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "vision/frame/av_input.h"

namespace egosieve::vision {
namespace {

struct Entry {
  int64_t time;  // in units of the stream's time base
  bool is_key;
};

// In the order of the file; empty if one of them is not reliable.
std::vector<Entry> ReadEntries(AvInput& input) {
  const Packet packet(av_packet_alloc());
  std::vector<Entry> entries;
  int code = 0;
  while (packet != nullptr && (code = input.Read(packet.get())) >= 0) {
    if (packet->pts == AV_NOPTS_VALUE ||
        (packet->flags & (AV_PKT_FLAG_CORRUPT | AV_PKT_FLAG_DISCARD)) != 0) {
      return {};
    }
    entries.push_back({packet->pts, (packet->flags & AV_PKT_FLAG_KEY) != 0});
  }
  if (code != AVERROR_EOF) entries.clear();
  return entries;
}

}  // namespace

std::optional<VideoIndex> VideoIndex::Read(const std::string& path) {
  const std::unique_ptr<AvInput> input = AvInput::Open(path, 0);
  if (input == nullptr) return std::nullopt;
  std::vector<Entry> entries = ReadEntries(*input);
  if (entries.empty() || !entries.front().is_key) return std::nullopt;
  const int64_t first_time = entries.front().time;
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.time < b.time; });
  if (entries.front().time != first_time) return std::nullopt;
  const auto twice =
      std::adjacent_find(entries.begin(), entries.end(),
                         [](const Entry& a, const Entry& b) { return a.time == b.time; });
  if (twice != entries.end()) return std::nullopt;
  VideoIndex index;
  for (const Entry& entry : entries) {
    if (entry.is_key) index.keys_.push_back(index.size());
    index.times_.push_back(entry.time);
  }
  return index;
}

}  // namespace egosieve::vision
