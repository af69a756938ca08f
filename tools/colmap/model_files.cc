#include "tools/colmap/model_files.h"

#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");
static_assert(sizeof(Observation) == 24 && sizeof(TrackElement) == 8, "read without gaps");

template <typename T, typename U>
concept Is = std::is_same_v<std::remove_const_t<T>, U>;

// The items are walked once, by the functions below, for each of four streams:
//
//   Value     a number
//   Model     the number of a camera model; in text its name
//   Name      the rest of a line; in binary files it ends with a 0
//   Line      text goes on in the next line
//   Items     all of a line, Records: all of the file; in binary files behind their number

// The bytes that an item has at least in a binary file.
template <typename Item>
constexpr size_t kLeastBytes = sizeof(Item);
template <>
constexpr size_t kLeastBytes<SparseCamera> = 24;
template <>
constexpr size_t kLeastBytes<SparseImage> = 73;
template <>
constexpr size_t kLeastBytes<SparsePoint> = 51;

template <typename Stream, Is<SparseCamera> Camera>
void Walk(Stream& stream, Camera& camera) {
  stream.Value(camera.id);
  stream.Model(camera.model);
  stream.Value(camera.width);
  stream.Value(camera.height);
  const CameraModel* model = FindCameraModel(camera.model);
  if (model == nullptr) return;
  if constexpr (Stream::kReads) camera.parameters.resize(model->parameters);
  for (auto& parameter : camera.parameters) stream.Value(parameter);
}

template <typename Stream, Is<Observation> Seen>
void Walk(Stream& stream, Seen& seen) {
  stream.Value(seen.x);
  stream.Value(seen.y);
  stream.Value(seen.point);
}

template <typename Stream, Is<SparseImage> Image>
void Walk(Stream& stream, Image& image) {
  stream.Value(image.id);
  for (auto& number : image.pose) stream.Value(number);
  stream.Value(image.camera);
  stream.Name(image.name);
  stream.Line();
  stream.Items(image.observations);
}

template <typename Stream, Is<TrackElement> Element>
void Walk(Stream& stream, Element& element) {
  stream.Value(element.image);
  stream.Value(element.observation);
}

template <typename Stream, Is<SparsePoint> Point>
void Walk(Stream& stream, Point& point) {
  stream.Value(point.id);
  for (auto& number : point.xyz) stream.Value(number);
  for (auto& number : point.rgb) stream.Value(number);
  stream.Value(point.error);
  stream.Items(point.track);
}

class BinaryReader {
 public:
  static constexpr bool kReads = true;
  explicit BinaryReader(absl::string_view bytes) : rest_(bytes), size_(bytes.size()) {}

  template <typename Number>
  void Value(Number& number) {
    if (!Has(sizeof(number))) return;
    std::memcpy(&number, rest_.data(), sizeof(number));
    rest_.remove_prefix(sizeof(number));
  }
  void Model(int32_t& model) {
    Value(model);
    if (FindCameraModel(model) == nullptr) {
      Fail(absl::StrCat("there is no camera model ", model));
    }
  }
  void Name(std::string& name) {
    const size_t length = rest_.find('\0');
    if (length == absl::string_view::npos) return Fail("a name has no end");
    name = std::string(rest_.substr(0, length));
    rest_.remove_prefix(length + 1);
  }
  void Line() {}
  template <typename Item>
  void Items(std::vector<Item>& items) {
    uint64_t count = 0;
    Value(count);
    if (count > rest_.size() / kLeastBytes<Item>) {
      return Fail(absl::StrCat(count, " items are more than the file holds"));
    }
    items.resize(count);
    for (Item& item : items) {
      if (!status.ok()) return;
      Walk(*this, item);
    }
  }
  template <typename Item>
  void Records(std::vector<Item>& items) {
    Items(items);
    if (!rest_.empty()) Fail("it has more bytes than its items");
  }

  absl::Status status;

 private:
  bool Has(size_t bytes) {
    if (status.ok() && rest_.size() < bytes) Fail("the file ends early");
    return status.ok();
  }
  void Fail(absl::string_view what) {
    if (!status.ok()) return;
    status = absl::DataLossError(absl::StrCat("byte ", size_ - rest_.size(), ": ", what));
  }

  absl::string_view rest_;
  size_t size_;
};

class BinaryWriter {
 public:
  static constexpr bool kReads = false;
  explicit BinaryWriter(const std::string& /*head*/) {}

  template <typename Number>
  void Value(const Number& number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  void Model(int32_t model) { Value(model); }
  void Name(const std::string& name) { bytes.append(name.c_str(), name.size() + 1); }
  void Line() {}
  template <typename Item>
  void Items(const std::vector<Item>& items) {
    Value(uint64_t{items.size()});
    for (const Item& item : items) Walk(*this, item);
  }
  template <typename Item>
  void Records(const std::vector<Item>& items) {
    Items(items);
  }

  std::string bytes;
};

class TextReader {
 public:
  static constexpr bool kReads = true;
  explicit TextReader(absl::string_view text) : text_(text) {}

  template <typename Number>
  void Value(Number& number) {
    const absl::string_view word = Word();
    bool is_number = false;
    if constexpr (std::is_floating_point_v<Number>) {
      is_number = absl::SimpleAtod(word, &number);
    } else if constexpr (sizeof(Number) == 1) {
      uint32_t value = 0;
      is_number = absl::SimpleAtoi(word, &value) && value <= 255;
      number = static_cast<Number>(value);
    } else {
      is_number = absl::SimpleAtoi(word, &number);
    }
    if (!is_number) Fail(word.empty() ? "a number is missing" : Quoted(word, "no such number"));
  }
  void Model(int32_t& model) {
    const absl::string_view word = Word();
    for (model = 0; FindCameraModel(model) != nullptr; ++model) {
      if (word == FindCameraModel(model)->name) return;
    }
    Fail(absl::StrCat("the model ", word, " is not known"));
  }
  void Name(std::string& name) {
    name = std::string(std::exchange(rest_, ""));
    if (name.empty()) Fail("the image has no name");
  }
  void Line() {
    if (!NextLine()) Fail("the file ends early");
  }
  template <typename Item>
  void Items(std::vector<Item>& items) {
    while (!rest_.empty() && status.ok()) Walk(*this, items.emplace_back());
  }
  template <typename Item>
  void Records(std::vector<Item>& items) {
    while (status.ok() && NextLine()) {
      if (rest_.empty() || rest_[0] == '#') continue;
      Walk(*this, items.emplace_back());
      if (!rest_.empty()) Fail(Quoted(rest_, "more than the line should hold"));
    }
  }

  absl::Status status;

 private:
  bool NextLine() {
    if (is_at_end_) return false;
    const size_t end = text_.find('\n');
    is_at_end_ = end == absl::string_view::npos;
    rest_ = absl::StripAsciiWhitespace(text_.substr(0, end));
    if (!is_at_end_) text_.remove_prefix(end + 1);
    ++line_;
    return true;
  }
  absl::string_view Word() {
    const absl::string_view word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_ = absl::StripLeadingAsciiWhitespace(rest_.substr(word.size()));
    return word;
  }
  static std::string Quoted(absl::string_view word, absl::string_view what) {
    return absl::StrCat("'", word.substr(0, 40), "' is ", what);
  }
  void Fail(absl::string_view what) {
    if (status.ok()) status = absl::DataLossError(absl::StrCat("line ", line_, ": ", what));
  }

  absl::string_view text_, rest_;  // after this line; of this line
  int64_t line_ = 0;
  bool is_at_end_ = false;
};

class TextWriter {
 public:
  static constexpr bool kReads = false;
  explicit TextWriter(std::string head) : bytes(std::move(head)) {}

  template <typename Number>
  void Value(const Number& number) {
    if constexpr (std::is_floating_point_v<Number>) {
      absl::StrAppendFormat(&bytes, "%.17g ", number);
    } else {
      absl::StrAppend(&bytes, number, " ");
    }
  }
  void Model(int32_t model) { absl::StrAppend(&bytes, FindCameraModel(model)->name, " "); }
  void Name(const std::string& name) { absl::StrAppend(&bytes, name, " "); }
  // No space ends a line.
  void Line() {
    if (bytes.back() == ' ') bytes.pop_back();
    bytes += '\n';
  }
  template <typename Item>
  void Items(const std::vector<Item>& items) {
    for (const Item& item : items) Walk(*this, item);
  }
  template <typename Item>
  void Records(const std::vector<Item>& items) {
    for (const Item& item : items) {
      Walk(*this, item);
      Line();
    }
  }

  std::string bytes;
};

template <typename Reader, typename Item>
absl::StatusOr<std::vector<Item>> ReadBy(absl::string_view bytes) {
  std::vector<Item> items;
  Reader reader(bytes);
  reader.Records(items);
  if (!reader.status.ok()) return reader.status;
  return items;
}

template <typename Writer, typename Item>
std::string WriteBy(const std::string& head, const std::vector<Item>& items) {
  Writer writer(head);
  writer.Records(items);
  return std::move(writer.bytes);
}

template <typename Item>
std::string Write(bool is_text, const std::string& head, const std::vector<Item>& items) {
  return is_text ? WriteBy<TextWriter>(head, items) : WriteBy<BinaryWriter>(head, items);
}

// Comments that begin a text file, as COLMAP writes them.
std::string Head(absl::string_view what, absl::string_view fields, absl::string_view items,
                 size_t count) {
  return absl::StrCat("# ", what, ":\n#   ", fields, "\n# Number of ", items, ": ", count);
}

std::string Mean(absl::string_view what, double sum, size_t count) {
  return absl::StrFormat(", mean %s: %.17g\n", what,
                         count == 0 ? 0.0 : sum / static_cast<double>(count));
}

}  // namespace

template <typename Item>
absl::StatusOr<std::vector<Item>> Parse(absl::string_view bytes, bool is_text) {
  return is_text ? ReadBy<TextReader, Item>(bytes) : ReadBy<BinaryReader, Item>(bytes);
}
template absl::StatusOr<std::vector<SparseCamera>> Parse(absl::string_view, bool);
template absl::StatusOr<std::vector<SparseImage>> Parse(absl::string_view, bool);
template absl::StatusOr<std::vector<SparsePoint>> Parse(absl::string_view, bool);

std::string Format(const std::vector<SparseCamera>& cameras, bool is_text) {
  const std::string head =
      Head("Camera list with one line of data per camera",
           "CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]", "cameras", cameras.size());
  return Write(is_text, head + "\n", cameras);
}

std::string Format(const std::vector<SparseImage>& images, bool is_text) {
  double observations = 0.0;
  for (const SparseImage& image : images) {
    for (const Observation& observation : image.observations) {
      observations += observation.point != kNoPoint;
    }
  }
  const std::string head =
      Head("Image list with two lines of data per image",
           "IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n#   POINTS2D[] as (X, Y, "
           "POINT3D_ID)",
           "images", images.size());
  return Write(is_text, head + Mean("observations per image", observations, images.size()), images);
}

std::string Format(const std::vector<SparsePoint>& points, bool is_text) {
  double elements = 0.0;
  for (const SparsePoint& point : points) elements += static_cast<double>(point.track.size());
  const std::string head =
      Head("3D point list with one line of data per point",
           "POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)", "points",
           points.size());
  return Write(is_text, head + Mean("track length", elements, points.size()), points);
}

}  // namespace egosieve::tools
