#include "gp/io/array_file.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they lie");

constexpr uint32_t kLocalSignature = 0x04034b50;
constexpr uint32_t kDirectorySignature = 0x02014b50;
constexpr uint32_t kEndSignature = 0x06054b50;
constexpr size_t kLocalSize = 30, kDirectorySize = 46, kEndSize = 22;
constexpr uint16_t kZipVersion = 20;
constexpr uint16_t kDosDate = 0x0021;  // 1980-01-01: the zero of zip's dates
constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
constexpr size_t kPreludeSize = 10;  // magic, version, header length
constexpr char kSuffix[] = ".npy";
constexpr size_t kSuffixSize = sizeof(kSuffix) - 1;

uint32_t Crc32(std::string_view bytes) {
  static const std::array<uint32_t, 256> table = [] {
    std::array<uint32_t, 256> entries{};
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ (value & 1 ? 0xEDB88320u : 0u);
      entries[i] = value;
    }
    return entries;
  }();
  uint32_t crc = 0xFFFFFFFFu;
  for (const char c : bytes) crc = (crc >> 8) ^ table[(crc ^ static_cast<uint8_t>(c)) & 0xFF];
  return ~crc;
}

template <typename T>
void Put(T value, std::string& out) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename T>
T Get(std::string_view bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <typename... Args>
absl::Status Damaged(const absl::FormatSpec<Args...>& format, const Args&... args) {
  return absl::DataLossError(absl::StrFormat(format, args...));
}

template <typename T>
constexpr std::string_view TypeCode() {
  if constexpr (std::is_same_v<T, double>) return "<f8";
  if constexpr (std::is_same_v<T, int64_t>) return "<i8";
  return "|u1";
}

std::string ToNpy(const NamedArray& array) {
  return std::visit(
      [&](const auto& elements) {
        using T = typename std::decay_t<decltype(elements)>::value_type;
        const std::string shape =
            absl::StrCat(absl::StrJoin(array.shape, ", "), array.shape.size() == 1 ? "," : "");
        std::string header = absl::StrFormat(
            "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }", TypeCode<T>(), shape);
        header.append(63 - (kPreludeSize + header.size()) % 64, ' ');
        header.push_back('\n');
        std::string out(kMagic);
        Put(static_cast<uint16_t>(header.size()), out);
        out += header;
        out.append(reinterpret_cast<const char*>(elements.data()), elements.size() * sizeof(T));
        return out;
      },
      array.elements);
}

// The fields that local headers and directory entries share, starting with the needed version.
void PutFileHeader(const std::string& name, uint32_t crc, uint32_t size, std::string& out) {
  Put(kZipVersion, out);
  Put<uint16_t>(0, out);  // flags
  Put<uint16_t>(0, out);  // stored
  Put<uint16_t>(0, out);  // time
  Put(kDosDate, out);
  Put(crc, out);
  Put(size, out);
  Put(size, out);
  Put(static_cast<uint16_t>(name.size()), out);
  Put<uint16_t>(0, out);  // extra
}

bool Take(std::string_view prefix, std::string_view& text) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

// "3, 4" or "3," or "" up to the closing parenthesis.
bool TakeShape(std::string_view& text, std::vector<int64_t>& shape) {
  while (!text.empty() && text[0] != ')') {
    int64_t extent = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), extent);
    if (error != std::errc() || extent < 0) return false;
    shape.push_back(extent);
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    if (!Take(", ", text)) Take(",", text);
  }
  return Take(")", text) && shape.size() <= 2;
}

template <typename T>
absl::Status TakeElements(const std::string& name, std::string_view data, NamedArray& array) {
  // The product of the shape cannot overflow if each extent is at most the number of bytes.
  uint64_t count = 1;
  for (const int64_t extent : array.shape) {
    if (extent != 0 && count > data.size() / static_cast<uint64_t>(extent)) {
      return Damaged("array %s: its shape asks for more than its %d bytes", name, data.size());
    }
    count *= static_cast<uint64_t>(extent);
  }
  if (count * sizeof(T) != data.size()) {
    return Damaged("array %s: %d elements in %d bytes", name, count, data.size());
  }
  std::vector<T> elements(count);
  if (count > 0) std::memcpy(elements.data(), data.data(), data.size());
  array.elements = std::move(elements);
  return absl::OkStatus();
}

absl::StatusOr<NamedArray> FromNpy(const std::string& name, std::string_view bytes) {
  if (bytes.size() < kPreludeSize || bytes.substr(0, kMagic.size()) != kMagic) {
    return Damaged("array %s: not in NumPy's format 1.0", name);
  }
  const size_t header_size = Get<uint16_t>(bytes, kMagic.size());
  if (header_size > bytes.size() - kPreludeSize) {
    return Damaged("array %s: its header is cut off", name);
  }
  std::string_view header = bytes.substr(kPreludeSize, header_size);
  const std::string_view data = bytes.substr(kPreludeSize + header_size);
  NamedArray array;
  if (!Take("{'descr': '", header)) return Damaged("array %s: unreadable header", name);
  const std::string_view type = header.substr(0, 3);
  header.remove_prefix(type.size());
  if (!Take("', 'fortran_order': False, 'shape': (", header)) {
    return absl::UnimplementedError(
        absl::StrFormat("array %s: only row-major arrays of 3-letter types are read", name));
  }
  if (!TakeShape(header, array.shape)) return Damaged("array %s: unreadable shape", name);
  absl::Status status;
  if (type == TypeCode<double>()) {
    status = TakeElements<double>(name, data, array);
  } else if (type == TypeCode<int64_t>()) {
    status = TakeElements<int64_t>(name, data, array);
  } else if (type == TypeCode<uint8_t>()) {
    status = TakeElements<uint8_t>(name, data, array);
  } else {
    status = absl::UnimplementedError(absl::StrFormat(
        "array %s: type '%s'; only <f8, <i8 and |u1 are read", name, std::string(type)));
  }
  if (!status.ok()) return status;
  return array;
}

// Extent of a member in the file, including its header.
struct Extent {
  size_t begin, end;
};

// The bytes of a member, given its directory entry's fields.
absl::StatusOr<std::string_view> Member(std::string_view bytes, const std::string& name,
                                        size_t offset, size_t size, uint32_t crc,
                                        std::vector<Extent>& taken) {
  if (offset > bytes.size() || bytes.size() - offset < kLocalSize ||
      Get<uint32_t>(bytes, offset) != kLocalSignature) {
    return Damaged("member %s: no header at byte %d", name, offset);
  }
  const size_t skipped = kLocalSize + Get<uint16_t>(bytes, offset + 26) +
                         static_cast<size_t>(Get<uint16_t>(bytes, offset + 28));
  if (bytes.size() - offset < skipped || bytes.size() - offset - skipped < size) {
    return Damaged("member %s: cut off", name);
  }
  const Extent extent = {offset, offset + skipped + size};
  for (const Extent& other : taken) {
    if (extent.begin < other.end && other.begin < extent.end) {
      return Damaged("member %s: lies over another", name);
    }
  }
  taken.push_back(extent);
  const std::string_view data = bytes.substr(offset + skipped, size);
#ifndef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION  // a fuzzer does not guess checksums
  if (Crc32(data) != crc) return Damaged("member %s: checksum does not match", name);
#endif
  return data;
}

}  // namespace

absl::StatusOr<std::string> SerializeArrays(const ArrayMap& arrays) {
  if (static_cast<int64_t>(arrays.size()) > kMaxArraysInFile) {
    return absl::FailedPreconditionError(
        absl::StrFormat("%d arrays; at most %d can be read", arrays.size(), kMaxArraysInFile));
  }
  std::string out, directory;
  for (const auto& [array_name, array] : arrays) {
    const std::string name = absl::StrCat(array_name, kSuffix);
    const std::string data = ToNpy(array);
    constexpr size_t kLimit = std::numeric_limits<uint32_t>::max();
    if (data.size() > kLimit || out.size() > kLimit - data.size() - kLocalSize - name.size() ||
        name.size() > 255) {
      return absl::FailedPreconditionError(
          absl::StrFormat("array %s: the archive would pass 4 GiB", array_name));
    }
    const uint32_t crc = Crc32(data);
    const uint32_t size = static_cast<uint32_t>(data.size());
    Put(kDirectorySignature, directory);
    Put(kZipVersion, directory);
    PutFileHeader(name, crc, size, directory);
    Put<uint16_t>(0, directory);  // comment
    Put<uint16_t>(0, directory);  // disk
    Put<uint16_t>(0, directory);  // attributes
    Put<uint32_t>(0, directory);
    Put(static_cast<uint32_t>(out.size()), directory);
    directory += name;
    Put(kLocalSignature, out);
    PutFileHeader(name, crc, size, out);
    out += name;
    out += data;
  }
  const uint16_t count = static_cast<uint16_t>(arrays.size());
  const uint32_t directory_offset = static_cast<uint32_t>(out.size());
  out += directory;
  Put(kEndSignature, out);
  Put<uint16_t>(0, out);  // disk
  Put<uint16_t>(0, out);
  Put(count, out);
  Put(count, out);
  Put(static_cast<uint32_t>(directory.size()), out);
  Put(directory_offset, out);
  Put<uint16_t>(0, out);  // comment
  return out;
}

absl::StatusOr<ArrayMap> ParseArrays(std::string_view bytes) {
  if (bytes.size() < kEndSize || Get<uint32_t>(bytes, bytes.size() - kEndSize) != kEndSignature) {
    return Damaged("not a complete .npz file: no directory at its end");
  }
  const std::string_view end = bytes.substr(bytes.size() - kEndSize);
  const int64_t count = Get<uint16_t>(end, 10);
  size_t place = Get<uint32_t>(end, 16);
  if (count > kMaxArraysInFile) {
    return Damaged("%d members; at most %d are read", count, kMaxArraysInFile);
  }
  const size_t directory_end = bytes.size() - kEndSize;
  if (place > directory_end || directory_end - place != Get<uint32_t>(end, 12)) {
    return Damaged("the directory's place does not fit the file's size");
  }
  const size_t directory_begin = place;
  std::vector<Extent> taken;
  ArrayMap arrays;
  for (int64_t i = 0; i < count; ++i) {
    if (place > bytes.size() || bytes.size() - place < kDirectorySize ||
        Get<uint32_t>(bytes, place) != kDirectorySignature) {
      return Damaged("directory entry %d is damaged", i);
    }
    const std::string_view entry = bytes.substr(place, kDirectorySize);
    const size_t name_size = Get<uint16_t>(entry, 28);
    const size_t entry_size = kDirectorySize + name_size + Get<uint16_t>(entry, 30) +
                              static_cast<size_t>(Get<uint16_t>(entry, 32));
    if (bytes.size() - place < entry_size) return Damaged("directory entry %d is cut off", i);
    const std::string name(bytes.substr(place + kDirectorySize, name_size));
    if (name.size() <= kSuffixSize || !name.ends_with(kSuffix)) {
      return Damaged("directory entry %d does not name an array", i);
    }
    if ((Get<uint16_t>(entry, 8) & 1) != 0 || Get<uint16_t>(entry, 10) != 0 ||
        Get<uint32_t>(entry, 20) != Get<uint32_t>(entry, 24)) {
      return absl::UnimplementedError(
          absl::StrFormat("directory entry %d is compressed or encrypted", i));
    }
    // Members lie before the directory and do not overlap: together they are no larger than the
    // file.
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::string_view data,
        Member(bytes.substr(0, directory_begin), absl::StrCat(i), Get<uint32_t>(entry, 42),
               Get<uint32_t>(entry, 24), Get<uint32_t>(entry, 16), taken));
    const std::string array_name = name.substr(0, name.size() - kSuffixSize);
    EGOSIEVE_ASSIGN_OR_RETURN(NamedArray array, FromNpy(absl::StrCat(i), data));
    if (!arrays.emplace(array_name, std::move(array)).second) {
      return Damaged("directory entry %d names an array twice", i);
    }
    place += entry_size;
  }
  if (place != directory_end) return Damaged("the directory holds more than its members");
  return arrays;
}

}  // namespace egosieve::gp
