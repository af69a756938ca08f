#include "vision/frame/whole_picture.h"

#include <csetjmp>
#include <cstdint>
#include <cstdio>  // jpeglib.h needs it
#include <string_view>
#include <vector>

extern "C" {
#include <jerror.h>
#include <jpeglib.h>
}

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace egosieve::vision {
namespace {

constexpr std::string_view kJpegEnd = "\xff\xd9";
// Behind the codes of the last line and before the next marker. Cameras leave a few; more are codes
// of a picture that lost others.
constexpr int kMostExtraneousBytes = 1024;

struct JpegErrors {
  jpeg_error_mgr manager;  // first: libjpeg knows this alone
  std::jmp_buf leave;
  char message[JMSG_LENGTH_MAX];
  bool is_without_end;
};

[[noreturn]] void Leave(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  jpeg->err->format_message(jpeg, errors->message);
  std::longjmp(errors->leave, 1);
}

// Warnings have a negative level.
void OnMessage(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  switch (jpeg->err->msg_code) {
    case JWRN_JPEG_EOF:
      reinterpret_cast<JpegErrors*>(jpeg->err)->is_without_end = true;
      return;
    case JWRN_EXTRANEOUS_DATA:
      if (jpeg->err->msg_parm.i[0] > kMostExtraneousBytes) Leave(jpeg);
      return;
    case JWRN_HIT_MARKER:  // the data of the lines end before the lines do
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
      Leave(jpeg);
    default:
      return;
  }
}

void Print(j_common_ptr) {}

// False with the decoder's message in `errors` if not all lines can be decoded. No object that
// longjmp would have to destroy is made here.
bool DecodeLines(std::string_view bytes, std::vector<JSAMPLE>& line, JpegErrors& errors) {
  jpeg_decompress_struct jpeg;
  jpeg.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = Leave;
  errors.manager.emit_message = OnMessage;
  errors.manager.output_message = Print;
  errors.is_without_end = false;
  jpeg_create_decompress(&jpeg);
  if (setjmp(errors.leave) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.scale_num = 1;
  jpeg.scale_denom = 8;
  jpeg_start_decompress(&jpeg);
  line.resize(static_cast<size_t>(jpeg.output_width) * jpeg.output_components);
  JSAMPROW row = line.data();
  while (jpeg.output_scanline < jpeg.output_height) jpeg_read_scanlines(&jpeg, &row, 1);
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return true;
}

absl::Status CheckJpeg(std::string& bytes) {
  std::vector<JSAMPLE> line;
  JpegErrors errors;
  if (!DecodeLines(bytes, line, errors)) {
    return absl::DataLossError(absl::StrCat(
        "the picture is cut short or damaged (",
        absl::AsciiStrToLower(static_cast<const char*>(errors.message)), "); copy it again"));
  }
  if (!errors.is_without_end) return absl::OkStatus();
  // Zeros are codes, too: a file whose blocks were reserved and never written.
  if (bytes.back() == '\0') {
    return absl::DataLossError("the picture is cut short: it ends in zeros; copy it again");
  }
  bytes.append(kJpegEnd);
  return absl::OkStatus();
}

absl::Status CheckPng(std::string_view bytes) {
  constexpr size_t kSignature = 8, kAround = 12;  // length, name and checksum of a chunk
  for (size_t place = kSignature; place + kAround <= bytes.size();) {
    uint32_t length = 0;
    for (int i = 0; i < 4; ++i) length = length << 8 | static_cast<uint8_t>(bytes[place + i]);
    if (bytes.substr(place + 4, 4) == "IEND") return absl::OkStatus();
    place += kAround + length;
  }
  return absl::DataLossError("the picture is cut short; copy it again");
}

}  // namespace

absl::Status CheckWhole(std::string& bytes) {
  if (bytes.starts_with("\x89PNG")) return CheckPng(bytes);
  if (bytes.starts_with("\xff\xd8\xff")) return CheckJpeg(bytes);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
