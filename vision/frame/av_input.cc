#include "vision/frame/av_input.h"

#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace egosieve::vision {
namespace {

uint64_t BigEndian(const uint8_t* bytes, int count) {
  uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

// The bytes at `place`; fewer at the file's end.
class File {
 public:
  explicit File(const std::string& path) : stream_(path, std::ios::binary) {
    std::error_code error;
    size_ = std::filesystem::file_size(path, error);
    if (error) size_ = 0;
  }
  uint64_t size() const { return size_; }
  int Read(uint64_t place, uint8_t* bytes, int count) {
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(place));
    stream_.read(reinterpret_cast<char*>(bytes), count);
    return static_cast<int>(stream_.gcount());
  }

 private:
  std::ifstream stream_;
  uint64_t size_ = 0;
};

struct Boxes {
  bool are_there = false;
  bool ends_within = false;
  bool has_table = false;  // moov or moof
};

// The boxes of ISO/IEC 14496-12 at the file's top, up to the first that is none.
Boxes ReadBoxes(File& file) {
  Boxes boxes;
  for (uint64_t place = 0; place + 8 <= file.size();) {
    std::array<uint8_t, 16> head{};
    const int count = file.Read(place, head.data(), static_cast<int>(head.size()));
    if (count < 8) break;
    const std::string_view type(reinterpret_cast<const char*>(&head[4]), 4);
    for (const char c : type) {
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != ' ') return boxes;
    }
    uint64_t length = BigEndian(head.data(), 4);
    if (length == 1 && count == 16) length = BigEndian(&head[8], 8);
    if (length == 0) length = file.size() - place;  // to the end of the file
    if (length < 8) return boxes;
    if (place == 0 && type != "ftyp" && type != "moov" && type != "mdat" && type != "wide") {
      return boxes;
    }
    boxes.are_there = true;
    const bool is_known = type == "mdat" || type == "moov" || type == "moof";
    if (is_known && length > file.size() - place) boxes.ends_within = true;
    boxes.has_table |= type == "moov" || type == "moof";
    if (length > file.size() - place) break;
    place += length;
  }
  return boxes;
}

// The end of a Matroska file's segment; 0 if it does not tell.
uint64_t EndOfSegment(File& file) {
  uint64_t place = 0;
  for (const uint32_t id : {0x1A45DFA3u, 0x18538067u}) {  // EBML's header, the segment
    std::array<uint8_t, 12> head{};
    if (file.Read(place, head.data(), 12) < 12 || BigEndian(head.data(), 4) != id) return 0;
    int bytes = 1;
    while (bytes <= 8 && (head[4] & (0x100 >> bytes)) == 0) ++bytes;
    if (bytes > 8) return 0;
    const uint64_t unknown = (uint64_t{1} << (7 * bytes)) - 1;
    const uint64_t length = BigEndian(&head[4], bytes) & unknown;
    if (length == unknown) return 0;
    place += 4 + bytes + length;
  }
  return place;
}

// The end of an AVI file's last chunk; 0 if it does not tell.
uint64_t EndOfRiff(File& file) {
  uint64_t place = 0;
  for (std::array<uint8_t, 12> head{}; file.Read(place, head.data(), 12) == 12;) {
    if (std::memcmp(head.data(), "RIFF", 4) != 0 || std::memcmp(&head[8], "AVI", 3) != 0) break;
    const uint64_t length = head[4] | head[5] << 8 | head[6] << 16 | uint64_t{head[7]} << 24;
    if (length == 0 || length == 0xFFFFFFFF) return 0;  // never closed
    place += 8 + length + length % 2;
  }
  return place;
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
  const std::string address = timeout_seconds > 0 ? path : "file:" + path;
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

bool EndsWithinAPart(const std::string& path) {
  File file(path);
  if (const Boxes boxes = ReadBoxes(file); boxes.are_there) return boxes.ends_within;
  return EndOfSegment(file) > file.size() || EndOfRiff(file) > file.size() + 1;
}

bool LacksSampleTable(const std::string& path) {
  File file(path);
  const Boxes boxes = ReadBoxes(file);
  return boxes.are_there && !boxes.has_table;
}

}  // namespace egosieve::vision
