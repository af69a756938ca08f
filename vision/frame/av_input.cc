#include "vision/frame/av_input.h"

#include <cctype>
#include <cstdio>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

struct CloseFile {
  void operator()(AVIOContext* file) const { avio_close(file); }
};
using File = std::unique_ptr<AVIOContext, CloseFile>;

// Whatever characters are in its path.
std::string FileAddress(const std::string& path) { return "file:" + path; }

File OpenFile(const std::string& path) {
  AVIOContext* file = nullptr;
  avio_open(&file, FileAddress(path).c_str(), AVIO_FLAG_READ);
  return File(file);
}

struct Boxes {
  bool are_there = false;
  bool ends_within = false;
  bool has_table = false;  // moov or moof
};

// The boxes of ISO/IEC 14496-12 at the file's top, up to the first that is none.
Boxes ReadBoxes(AVIOContext* file) {
  Boxes boxes;
  const int64_t size = avio_size(file);
  for (int64_t place = 0; place + 8 <= size;) {
    avio_seek(file, place, SEEK_SET);
    uint64_t length = avio_rb32(file);
    std::string type(4, '\0');
    avio_read(file, reinterpret_cast<uint8_t*>(type.data()), 4);
    for (const char c : type) {
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != ' ') return boxes;
    }
    const auto left = static_cast<uint64_t>(size - place);
    if (length == 1 && left >= 16) length = avio_rb64(file);
    if (length == 0) length = left;  // to the end of the file
    if (length < 8) return boxes;
    if (place == 0 && type != "ftyp" && type != "moov" && type != "mdat" && type != "wide") {
      return boxes;
    }
    boxes.are_there = true;
    boxes.has_table |= type == "moov" || type == "moof";
    if (length > left) {
      boxes.ends_within = type == "mdat" || type == "moov" || type == "moof";
      break;
    }
    place += static_cast<int64_t>(length);
  }
  return boxes;
}

// The end of a Matroska file's segment; 0 if it does not tell.
uint64_t EndOfSegment(AVIOContext* file) {
  uint64_t place = 0;
  for (const uint32_t id : {0x1A45DFA3u, 0x18538067u}) {  // EBML's header, the segment
    avio_seek(file, static_cast<int64_t>(place), SEEK_SET);
    if (place + 12 > static_cast<uint64_t>(avio_size(file)) || avio_rb32(file) != id) return 0;
    uint64_t length = avio_r8(file);
    int bytes = 1;
    while (bytes <= 8 && (length & (0x100 >> bytes)) == 0) ++bytes;
    if (bytes > 8) return 0;
    for (int i = 1; i < bytes; ++i) length = length << 8 | avio_r8(file);
    const uint64_t unknown = (uint64_t{1} << (7 * bytes)) - 1;
    length &= unknown;
    if (length == unknown) return 0;
    place += 4 + bytes + length;
  }
  return place;
}

// The end of an AVI file's last chunk; 0 if it does not tell.
uint64_t EndOfRiff(AVIOContext* file) {
  uint64_t place = 0;
  while (place + 12 <= static_cast<uint64_t>(avio_size(file))) {
    avio_seek(file, static_cast<int64_t>(place), SEEK_SET);
    const bool is_riff = avio_rl32(file) == MKTAG('R', 'I', 'F', 'F');
    const uint64_t length = avio_rl32(file);
    if (!is_riff || avio_rb24(file) != (('A' << 16) | ('V' << 8) | 'I')) break;
    if (length == 0 || length == 0xFFFFFFFF) return 0;  // never closed
    place += 8 + length + length % 2;
  }
  return place;
}

// Creation times are in whole seconds, and cameras need a moment to begin a file.
constexpr double kGapSeconds = 3.0;

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

struct Recorded {
  double begin_seconds = 0.0, length_seconds = 0.0;
};

std::optional<Recorded> RecordedOf(const AVFormatContext& context) {
  const AVDictionaryEntry* created = av_dict_get(context.metadata, "creation_time", nullptr, 0);
  absl::Time time;
  if (created == nullptr || context.duration <= 0 ||
      !absl::ParseTime(absl::RFC3339_full, created->value, &time, nullptr) ||
      time <= absl::UnixEpoch()) {
    return std::nullopt;
  }
  return Recorded{absl::ToDoubleSeconds(time - absl::UnixEpoch()),
                  static_cast<double>(context.duration) / AV_TIME_BASE};
}

void AddOnTimes(const std::vector<std::string>& paths, const std::vector<Recorded>& spans,
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

std::unique_ptr<AvInput> AvInput::Open(const std::string& path, int timeout_seconds) {
  std::unique_ptr<AvInput> input(new AvInput(timeout_seconds));
  AVFormatContext* opened = avformat_alloc_context();
  if (opened == nullptr) return nullptr;
  opened->interrupt_callback = {IsLate, input.get()};
  AVDictionary* options = nullptr;
  if (timeout_seconds > 0) av_dict_set(&options, "rtsp_transport", "tcp", 0);
  input->SetDeadline();
  const std::string address = timeout_seconds > 0 ? path : FileAddress(path);
  const int code = avformat_open_input(&opened, address.c_str(), nullptr, &options);
  av_dict_free(&options);
  if (code < 0) return nullptr;  // it has freed the context
  input->context_ = opened;
  if (avformat_find_stream_info(opened, nullptr) < 0) return nullptr;
  input->stream_ = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (input->stream_ < 0 || (input->video()->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0) {
    return nullptr;
  }
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    if (static_cast<int>(i) != input->stream_) opened->streams[i]->discard = AVDISCARD_ALL;
  }
  return input;
}

AvInput::~AvInput() { avformat_close_input(&context_); }

void AvInput::SetDeadline() {
  deadline_ = std::chrono::steady_clock::now() + std::chrono::seconds(timeout_seconds_);
}

int AvInput::IsLate(void* input) {
  const auto* self = static_cast<const AvInput*>(input);
  return self->timeout_seconds_ > 0 && std::chrono::steady_clock::now() > self->deadline_ ? 1 : 0;
}

int AvInput::Read(AVPacket* packet) {
  SetDeadline();
  while (true) {
    av_packet_unref(packet);
    const int code = av_read_frame(context_, packet);
    if (code < 0 || packet->stream_index == stream_) return code;
  }
}

bool AvInput::SeekTo(int64_t time) {
  return av_seek_frame(context_, stream_, time, AVSEEK_FLAG_BACKWARD) >= 0;
}

std::optional<VideoIndex> VideoIndex::Read(const std::string& path) {
  const std::unique_ptr<AvInput> input = AvInput::Open(path, 0);
  const Packet packet(av_packet_alloc());
  if (input == nullptr || packet == nullptr) return std::nullopt;
  std::map<int64_t, bool> are_keys;  // by time
  std::optional<int64_t> first_time;
  int code = 0;
  while ((code = input->Read(packet.get())) >= 0) {
    const bool is_whole = (packet->flags & (AV_PKT_FLAG_CORRUPT | AV_PKT_FLAG_DISCARD)) == 0;
    const bool is_key = (packet->flags & AV_PKT_FLAG_KEY) != 0;
    if (packet->pts == AV_NOPTS_VALUE || !is_whole ||
        !are_keys.emplace(packet->pts, is_key).second) {
      return std::nullopt;
    }
    if (!first_time) first_time = packet->pts;
  }
  if (code != AVERROR_EOF || !first_time) return std::nullopt;
  if (are_keys.begin()->first != *first_time || !are_keys.begin()->second) return std::nullopt;
  VideoIndex index;
  for (const auto& [time, is_key] : are_keys) {
    if (is_key) index.keys_.push_back(index.size());
    index.times_.push_back(time);
  }
  return index;
}

bool EndsWithinAPart(const std::string& path) {
  const File file = OpenFile(path);
  if (file == nullptr) return false;
  if (const Boxes boxes = ReadBoxes(file.get()); boxes.are_there) return boxes.ends_within;
  const auto size = static_cast<uint64_t>(avio_size(file.get()));
  return EndOfSegment(file.get()) > size || EndOfRiff(file.get()) > size + 1;
}

bool LacksSampleTable(const std::string& path) {
  const File file = OpenFile(path);
  const Boxes boxes = file == nullptr ? Boxes() : ReadBoxes(file.get());
  return boxes.are_there && !boxes.has_table;
}

std::vector<std::string> RemarksOnVideos(const std::vector<std::string>& paths) {
  QuietLibraries();
  std::vector<std::string> remarks;
  std::vector<Recorded> spans;
  for (const std::string& path : paths) {
    const std::unique_ptr<AvInput> input = AvInput::Open(path, 0);
    if (input == nullptr) break;
    if (&path == &paths.front()) AddOnPictures(path, *input->video()->codecpar, remarks);
    const std::optional<Recorded> span = RecordedOf(*input->context());
    if (!span) break;
    spans.push_back(*span);
  }
  if (spans.size() == paths.size()) AddOnTimes(paths, spans, remarks);
  return remarks;
}

}  // namespace egosieve::vision
