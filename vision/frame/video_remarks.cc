#include "vision/frame/video_remarks.h"

#include <algorithm>
#include <memory>
#include <optional>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "vision/frame/av_input.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

void AddOnPictures(const std::string& path, const AVCodecParameters& video,
                   std::vector<std::string>& remarks) {
  if (video.field_order > AV_FIELD_PROGRESSIVE) {
    remarks.push_back(absl::StrCat(
        path, " is interlaced, and what moves has combed edges; deinterlace it: ffmpeg -i ", path,
        " -vf bwdif=send_frame OUT.mp4"));
  }
  const bool is_pq = video.color_trc == AVCOL_TRC_SMPTE2084;
  if (is_pq || video.color_trc == AVCOL_TRC_ARIB_STD_B67) {
    remarks.push_back(absl::StrCat(
        path, " is HDR (", is_pq ? "PQ" : "HLG",
        ") and is read with little contrast; convert it: ffmpeg -i ", path,
        " -vf zscale=t=linear:npl=100,tonemap=hable,zscale=t=bt709,format=yuv420p OUT.mp4"));
  }
}

struct Span {
  double begin_seconds = 0.0, length_seconds = 0.0;
};

std::optional<Span> SpanOf(const AVFormatContext& context) {
  const AVDictionaryEntry* created = av_dict_get(context.metadata, "creation_time", nullptr, 0);
  absl::Time time;
  if (created == nullptr || context.duration <= 0 ||
      !absl::ParseTime(absl::RFC3339_full, created->value, &time, nullptr) ||
      time <= absl::UnixEpoch()) {
    return std::nullopt;
  }
  return Span{absl::ToDoubleSeconds(time - absl::UnixEpoch()),
              static_cast<double>(context.duration) / AV_TIME_BASE};
}

void AddOnTimes(const std::vector<std::string>& paths, const std::vector<Span>& spans,
                std::vector<std::string>& remarks) {
  int gaps = 0;
  std::string first;
  double missing = 0.0;
  for (size_t i = 0; i + 1 < spans.size(); ++i) {
    const double between = spans[i + 1].begin_seconds - spans[i].begin_seconds;
    if (between < 0) {
      remarks.push_back(absl::StrCat(paths[i + 1], " was recorded before ", paths[i],
                                     ", which is read before it; name them in their order, or list "
                                     "them in a .txt"));
      return;
    }
    // Some cameras write the time at which a file ends.
    const double gap = between - std::max(spans[i].length_seconds, spans[i + 1].length_seconds);
    if (!(gap > kGapSeconds)) continue;
    if (gaps++ == 0) first = paths[i];
    missing += gap;
  }
  if (gaps == 0) return;
  remarks.push_back(absl::StrFormat(
      "%d gaps between the videos, the first behind %s: %.0f s are missing, and times go on as if "
      "there were none; give parts that belong together one by one",
      gaps, first, missing));
}

}  // namespace

std::vector<std::string> RemarksOnVideos(const std::vector<std::string>& paths) {
  QuietLibraries();
  std::vector<std::string> remarks;
  std::vector<Span> spans;
  for (const std::string& path : paths) {
    const std::unique_ptr<AvInput> input = AvInput::Open(path, 0);
    if (input == nullptr) break;
    if (&path == &paths.front()) AddOnPictures(path, *input->video()->codecpar, remarks);
    const std::optional<Span> span = SpanOf(*input->context());
    if (!span) break;
    spans.push_back(*span);
  }
  if (spans.size() == paths.size()) AddOnTimes(paths, spans, remarks);
  return remarks;
}

}  // namespace egosieve::vision
