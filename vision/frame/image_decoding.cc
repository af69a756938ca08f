#include "vision/frame/image_decoding.h"

#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "vision/frame/quiet_libraries.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

// Whether a picture file is whole, before OpenCV decodes it: OpenCV fills what is missing with grey
// or black, and libraries tell of it on stderr alone.
//
//   JPEG   libjpeg decodes the file at an eighth of its size. It is damaged if the decoder runs out
//          of data before the last line, finds codes that no encoder writes, or has many left. What
//          lies behind the picture (the video of a motion photo, padding, trailers) does not matter
//   PNG    the chain of chunks, each with its length, reaches IEND
//
// What has too many pixels by its header is refused before that.
//
// Other formats are left to their decoders.

constexpr std::string_view kJpegEnd = "\xff\xd9";
// Behind the codes of the last line and before the next marker. Cameras leave a few; more are codes
// of a picture that lost others.
constexpr int kMostExtraneousBytes = 1024;

struct JpegErrors {
  jpeg_error_mgr manager;  // first: libjpeg knows this alone
  std::jmp_buf leave;
  char message[JMSG_LENGTH_MAX];
  bool is_without_end;
  int64_t width, height;  // where the decoder failed; 0 before the header is read
};

[[noreturn]] void Leave(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  jpeg->err->format_message(jpeg, errors->message);
  errors->width = reinterpret_cast<j_decompress_ptr>(jpeg)->image_width;
  errors->height = reinterpret_cast<j_decompress_ptr>(jpeg)->image_height;
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

// False with the decoder's message in `errors` if not all lines can be decoded. No object that
// longjmp would have to destroy is made here.
bool DecodeLines(std::string_view bytes, std::vector<JSAMPLE>& line, JpegErrors& errors) {
  jpeg_decompress_struct jpeg;
  jpeg.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = Leave;
  errors.manager.emit_message = OnMessage;
  errors.manager.output_message = [](j_common_ptr) {};
  errors.is_without_end = false;
  jpeg_create_decompress(&jpeg);
  if (setjmp(errors.leave) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  if (int64_t{jpeg.image_width} * jpeg.image_height > kMaximumPixels) {
    Leave(reinterpret_cast<j_common_ptr>(&jpeg));
  }
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

absl::Status CheckWholeJpeg(std::string& bytes) {
  std::vector<JSAMPLE> line;
  JpegErrors errors;
  if (!DecodeLines(bytes, line, errors)) {
    EGOSIEVE_RETURN_IF_ERROR(CheckPixels(errors.width, errors.height));
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

absl::Status CheckWholePng(std::string_view bytes) {
  constexpr size_t kSignature = 8, kAround = 12;  // length, name and checksum of a chunk
  constexpr size_t kWidth = 16, kHeight = 20, kSizesEnd = 24;
  const auto number = [&](size_t place) {
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(bytes[place + i]);
    return value;
  };
  if (bytes.size() >= kSizesEnd) {
    EGOSIEVE_RETURN_IF_ERROR(CheckPixels(number(kWidth), number(kHeight)));
  }
  for (size_t place = kSignature; place + kAround <= bytes.size();) {
    if (bytes.substr(place + 4, 4) == "IEND") return absl::OkStatus();
    place += kAround + number(place);
  }
  return absl::DataLossError("the picture is cut short; copy it again");
}

// DataLoss, with the decoder's words, if it is damaged or cut short. A JPEG that lacks its end
// marker alone gets one.
absl::Status CheckWhole(std::string& bytes) {
  if (bytes.starts_with("\x89PNG")) return CheckWholePng(bytes);
  if (bytes.starts_with("\xff\xd8\xff")) return CheckWholeJpeg(bytes);
  return absl::OkStatus();
}

constexpr int64_t kMaximumBytes = std::numeric_limits<int>::max();  // they are one row of a cv::Mat

// Whether the bytes begin like a picture that is read. OpenCV passes all others to GDAL and
// GDCM, which end the process on some inputs.
bool BeginsAsPicture(std::string_view bytes) {
  constexpr std::string_view kBegins[] = {"\x89PNG",    "\xff\xd8\xff",      "BM",
                                          {"II*\0", 4}, {"MM\0*", 4},        {"II+\0", 4},
                                          {"MM\0+", 4}, {"\0\0\0\x0cjP", 6}, "\xff\x4f\xff\x51"};
  if (bytes.size() > 12 && bytes.starts_with("RIFF")) return bytes.substr(8, 4) == "WEBP";
  if (bytes.size() > 2 && bytes[0] == 'P') return bytes[1] >= '1' && bytes[1] <= '7';
  return std::any_of(std::begin(kBegins), std::end(kBegins),
                     [&](std::string_view begin) { return bytes.starts_with(begin); });
}

// "HEIC" or "AVIF" for their files, whatever the file's name is; else empty.
std::string KindOfBox(std::string_view bytes) {
  if (bytes.size() < 12 || bytes.substr(4, 4) != "ftyp") return "";
  const std::string_view brand = bytes.substr(8, 4);
  if (brand == "avif" || brand == "avis") return "AVIF";
  constexpr std::string_view kHeic[] = {"heic", "heix", "heim", "heis", "hevc", "mif1", "msf1"};
  return std::count(std::begin(kHeic), std::end(kHeic), brand) > 0 ? "HEIC" : "";
}

// The picture as it is stored, of any type, turned as EXIF says.
absl::StatusOr<cv::Mat> Decode(const std::string& path) {
  QuietLibraries();
  EGOSIEVE_ASSIGN_OR_RETURN(std::string bytes, kernels::ReadFile(path, kMaximumBytes));
  const auto failed = [&](absl::string_view what) {
    return absl::DataLossError(absl::StrCat(path, ": ", what));
  };
  if (bytes.empty()) return failed("the file is empty");
  if (const std::string kind = KindOfBox(bytes); !kind.empty()) {
    return failed(absl::StrCat("a ", kind, " picture, which is not read; convert it to JPEG"));
  }
  if (!BeginsAsPicture(bytes)) return failed("cannot be decoded as a picture");
  if (const absl::Status whole = CheckWhole(bytes); !whole.ok()) return failed(whole.message());
  cv::Mat picture;
  try {
    const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8U, bytes.data());
    picture = cv::imdecode(row, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
  } catch (const cv::Exception& error) {
    return failed(absl::StrCat("cannot be decoded (", error.err, ")"));
  }
  if (picture.empty()) return failed("cannot be decoded as a picture");
  return picture;
}

bool IsDeep(int depth) { return depth == CV_16U || depth == CV_32F || depth == CV_64F; }

double FullScale(int depth) { return depth == CV_16U ? 65535.0 : 1.0; }

// Appends values of the picture without alpha, at most kMostValues, evenly spaced.
void Sample(const cv::Mat& picture, std::vector<double>& values) {
  constexpr size_t kMostValues = 1 << 16;
  cv::Mat doubles;
  picture.convertTo(doubles, CV_64F);
  const size_t step = picture.total() / kMostValues + 1, channels = picture.channels();
  const auto* all = doubles.ptr<double>();
  for (size_t place = 0; place < picture.total(); place += step) {
    for (size_t c = 0; c < std::min<size_t>(channels, 3); ++c) {
      const double value = all[place * channels + c];
      if (std::isfinite(value)) values.push_back(value);
    }
  }
}

std::optional<ValueRange> RangeOf(std::vector<double>& values, int depth) {
  constexpr double kTail = 0.001;
  const bool are_bytes = depth == CV_16U && std::all_of(values.begin(), values.end(), [](double v) {
                           return std::fmod(v, 257.0) == 0.0;
                         });
  if (values.empty() || are_bytes) return std::nullopt;
  const ValueRange range = {QuantileInPlace(values, kTail), QuantileInPlace(values, 1.0 - kTail)};
  const double scale = FullScale(depth);
  const bool fits = range.low >= 0.0 && range.high <= scale;
  if (!(range.high > range.low) || (fits && range.high - range.low >= scale / 2)) {
    return std::nullopt;
  }
  return range;
}

}  // namespace

absl::Status CheckPixels(int64_t width_pixels, int64_t height_pixels) {
  if (width_pixels <= 0 || height_pixels <= kMaximumPixels / width_pixels) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "%d x %d pixels are more than the %d that are taken; make the picture smaller", width_pixels,
      height_pixels, kMaximumPixels));
}

std::string ExtensionOf(const std::string& path) {
  return absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
}

bool HasImageExtension(const std::string& path) {
  constexpr std::string_view kExtensions[] = {".png", ".jpg",  ".jpeg", ".jpe", ".bmp",
                                              ".tif", ".tiff", ".pgm",  ".ppm", ".pnm",
                                              ".pbm", ".webp", ".jp2"};
  return std::count(std::begin(kExtensions), std::end(kExtensions), ExtensionOf(path)) > 0;
}

std::string UnreadPictureKind(const std::string& path) {
  constexpr std::string_view kKinds[] = {".heic", ".heif", ".avif", ".jxl", ".dng",
                                         ".cr2",  ".cr3",  ".nef",  ".arw", ".raf"};
  const std::string extension = ExtensionOf(path);
  const bool is_one = std::count(std::begin(kKinds), std::end(kKinds), extension) > 0;
  return is_one ? absl::AsciiStrToUpper(extension.substr(1)) : "";
}

absl::StatusOr<DecodedImage> ConvertToBgr(const cv::Mat& picture,
                                          const std::optional<ValueRange>& range) {
  if (picture.empty()) return absl::InvalidArgumentError("the picture has no pixels");
  EGOSIEVE_RETURN_IF_ERROR(CheckPixels(picture.cols, picture.rows));
  const int depth = picture.depth(), channels = picture.channels();
  if (depth != CV_8U && !IsDeep(depth)) {
    return absl::InvalidArgumentError(
        absl::StrCat("pictures of OpenCV depth ", depth, " are not supported"));
  }
  if (channels != 1 && channels != 3 && channels != 4) {
    return absl::InvalidArgumentError(
        absl::StrCat("pictures of ", channels, " channels are not supported"));
  }
  DecodedImage result{picture, channels == 1};
  if (IsDeep(depth)) {
    const ValueRange from = range.value_or(ValueRange{0.0, FullScale(depth)});
    const double scale = 255.0 / (from.high - from.low);
    picture.convertTo(result.image, CV_8U, scale, -from.low * scale);
  }
  const cv::Mat bytes = result.image;
  if (channels == 1) cv::cvtColor(bytes, result.image, cv::COLOR_GRAY2BGR);
  if (channels == 4) cv::cvtColor(bytes, result.image, cv::COLOR_BGRA2BGR);
  return result;
}

absl::StatusOr<DecodedImage> DecodeImageFile(const std::string& path,
                                             const std::optional<ValueRange>& range) {
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat picture, Decode(path));
  absl::StatusOr<DecodedImage> converted = ConvertToBgr(picture, range);
  if (!converted.ok()) {
    return absl::DataLossError(absl::StrCat(path, ": ", converted.status().message()));
  }
  return converted;
}

absl::StatusOr<std::optional<ValueRange>> RangeOfDrive(const std::vector<std::string>& paths) {
  constexpr size_t kMostPictures = 32;
  const size_t count = std::min(paths.size(), kMostPictures);
  std::vector<double> values;
  int depth = -1;
  for (size_t i = 0; i < count; ++i) {
    const size_t index = count == 1 ? 0 : i * (paths.size() - 1) / (count - 1);
    const absl::StatusOr<cv::Mat> picture = Decode(paths[index]);
    if (kernels::IsOfTheMachine(picture.status())) return picture.status();
    if (!picture.ok()) continue;
    if (depth < 0) depth = picture->depth();
    if (!IsDeep(depth)) break;
    if (picture->depth() == depth) Sample(*picture, values);
  }
  return RangeOf(values, depth);
}

}  // namespace egosieve::vision
