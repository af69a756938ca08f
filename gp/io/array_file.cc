#include "gp/io/array_file.h"

#include <zip.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <iterator>
#include <list>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written in the host's byte order");

constexpr uint64_t kMaximumBytes = uint64_t{1} << 32;
constexpr uint16_t kDosDate = 0x0021;  // 1980-01-01: the zero of zip's dates
constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
constexpr size_t kPreludeSize = 10;  // magic, version, header length
constexpr char kSuffix[] = ".npy";
constexpr size_t kSuffixSize = sizeof(kSuffix) - 1;

struct Free {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* member) const { zip_fclose(member); }
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Archive = std::unique_ptr<zip_t, Free>;
using Source = std::unique_ptr<zip_source_t, Free>;

template <typename T>
constexpr std::string_view TypeCode() {
  if constexpr (std::is_same_v<T, double>) return "<f8";
  if constexpr (std::is_same_v<T, int64_t>) return "<i8";
  return "|u1";
}

zip_buffer_fragment_t Fragment(const void* data, size_t size) {
  return {static_cast<zip_uint8_t*>(const_cast<void*>(data)), size};
}

zip_buffer_fragment_t Elements(const NamedArray& array) {
  return std::visit([](const auto& e) { return Fragment(e.data(), e.size() * sizeof(e[0])); },
                    array.elements);
}

// All that comes before the elements.
std::string NpyHeader(const NamedArray& array) {
  const std::string_view type = std::visit(
      [](const auto& e) { return TypeCode<typename std::decay_t<decltype(e)>::value_type>(); },
      array.elements);
  std::string text = absl::StrFormat(
      "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }", std::string(type),
      absl::StrCat(absl::StrJoin(array.shape, ", "), array.shape.size() == 1 ? "," : ""));
  text.append(63 - (kPreludeSize + text.size()) % 64, ' ');
  text.push_back('\n');
  const uint16_t size = static_cast<uint16_t>(text.size());
  std::string header(kMagic);
  header.append(reinterpret_cast<const char*>(&size), sizeof(size));
  return header + text;
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
    EGOSIEVE_REQUIRE(DataLoss, extent == 0 || count <= data.size() / static_cast<uint64_t>(extent),
                     "array %s: its shape needs more than its %d bytes", name, data.size());
    count *= static_cast<uint64_t>(extent);
  }
  EGOSIEVE_REQUIRE(DataLoss, count * sizeof(T) == data.size(), "array %s: %d elements in %d bytes",
                   name, count, data.size());
  std::vector<T> elements(count);
  if (count > 0) std::memcpy(elements.data(), data.data(), data.size());
  array.elements = std::move(elements);
  return absl::OkStatus();
}

absl::StatusOr<NamedArray> FromNpy(const std::string& name, std::string_view bytes) {
  EGOSIEVE_REQUIRE(DataLoss,
                   bytes.size() >= kPreludeSize && bytes.substr(0, kMagic.size()) == kMagic,
                   "array %s: not in NumPy's format 1.0", name);
  uint16_t header_size = 0;
  std::memcpy(&header_size, bytes.data() + kMagic.size(), sizeof(header_size));
  EGOSIEVE_REQUIRE(DataLoss, header_size <= bytes.size() - kPreludeSize,
                   "array %s: its header is cut off", name);
  std::string_view header = bytes.substr(kPreludeSize, header_size);
  const std::string_view data = bytes.substr(kPreludeSize + header_size);
  NamedArray array;
  EGOSIEVE_REQUIRE(DataLoss, Take("{'descr': '", header), "array %s: unreadable header", name);
  const std::string_view type = header.substr(0, 3);
  header.remove_prefix(type.size());
  EGOSIEVE_REQUIRE(Unimplemented, Take("', 'fortran_order': False, 'shape': (", header),
                   "array %s: only row-major arrays of 3-letter types are read", name);
  EGOSIEVE_REQUIRE(DataLoss, TakeShape(header, array.shape), "array %s: unreadable shape", name);
  const bool is_double = type == TypeCode<double>(), is_integer = type == TypeCode<int64_t>();
  EGOSIEVE_REQUIRE(Unimplemented, is_double || is_integer || type == TypeCode<uint8_t>(),
                   "array %s: type '%s'; only <f8, <i8 and |u1 are read", name, std::string(type));
  EGOSIEVE_RETURN_IF_ERROR(is_double    ? TakeElements<double>(name, data, array)
                           : is_integer ? TakeElements<int64_t>(name, data, array)
                                        : TakeElements<uint8_t>(name, data, array));
  return array;
}

absl::Status ZipError(absl::StatusCode code, const std::string& what, zip_error_t* error) {
  if (zip_error_code_zip(error) == ZIP_ER_MEMORY) code = absl::StatusCode::kResourceExhausted;
  return absl::Status(code, absl::StrCat(what, ": ", zip_error_strerror(error)));
}

// The archive shares `source`.
absl::StatusOr<Archive> Open(zip_source_t* source, int flags) {
  EGOSIEVE_REQUIRE(ResourceExhausted, source != nullptr, "out of memory");
  zip_error_t error;
  zip_error_init(&error);
  zip_source_keep(source);
  Archive archive(zip_open_from_source(source, flags, &error));
  if (archive != nullptr) return archive;
  zip_source_free(source);
  const absl::Status status =
      ZipError(absl::StatusCode::kDataLoss, "not a complete .npz file", &error);
  zip_error_fini(&error);
  return status;
}

// The archive refers to the header and to the array's elements until it is closed.
absl::Status AddMember(const std::string& name, const std::string& header, const NamedArray& array,
                       zip_t* archive) {
  const zip_buffer_fragment_t fragments[] = {Fragment(header.data(), header.size()),
                                             Elements(array)};
  Source source(zip_source_buffer_fragment(archive, fragments, std::size(fragments), 0));
  const zip_int64_t index =
      source == nullptr ? -1 : zip_file_add(archive, name.c_str(), source.get(), 0);
  if (index >= 0) (void)source.release();  // the archive has it
  if (index < 0 || zip_set_file_compression(archive, index, ZIP_CM_STORE, 0) != 0 ||
      zip_file_set_dostime(archive, index, 0, kDosDate, 0) != 0 ||
      zip_file_set_external_attributes(archive, index, 0, ZIP_OPSYS_DOS, 0) != 0) {
    return ZipError(absl::StatusCode::kFailedPrecondition, name, zip_get_error(archive));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> BytesOf(zip_source_t* source) {
  zip_stat_t stat;
  if (zip_source_stat(source, &stat) == 0 && zip_source_open(source) == 0) {
    std::string bytes(stat.size, '\0');
    const zip_int64_t read = zip_source_read(source, bytes.data(), bytes.size());
    zip_source_close(source);
    if (read == static_cast<zip_int64_t>(bytes.size())) return bytes;
  }
  return ZipError(absl::StatusCode::kInternal, "the archive", zip_source_error(source));
}

// The bytes of the member `index`, if there are `size` of them.
absl::StatusOr<std::string> ReadMember(zip_t* archive, zip_uint64_t index, size_t size) {
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  constexpr zip_flags_t kFlags = ZIP_FL_COMPRESSED;  // a fuzzer does not guess checksums
#else
  constexpr zip_flags_t kFlags = 0;
#endif
  const std::string what = absl::StrCat("member ", index);
  const std::unique_ptr<zip_file_t, Free> member(zip_fopen_index(archive, index, kFlags));
  if (member == nullptr) {
    return ZipError(absl::StatusCode::kDataLoss, what, zip_get_error(archive));
  }
  std::string bytes(size, '\0');
  char beyond;  // libzip compares the checksum when it reaches the member's end
  const zip_int64_t read = zip_fread(member.get(), bytes.data(), size);
  const zip_int64_t more = read < 0 ? read : zip_fread(member.get(), &beyond, 1);
  if (more < 0) {
    return ZipError(absl::StatusCode::kDataLoss, what, zip_file_get_error(member.get()));
  }
  EGOSIEVE_REQUIRE(DataLoss, read == static_cast<zip_int64_t>(size) && more == 0,
                   "%s: it has not the size of its directory entry", what);
  return bytes;
}

}  // namespace

absl::StatusOr<std::string> SerializeArrays(const ArrayMap& arrays) {
  EGOSIEVE_REQUIRE(FailedPrecondition,
                   !arrays.empty() && static_cast<int64_t>(arrays.size()) <= kMaxArraysInFile,
                   "%d arrays; from 1 to %d can be read", arrays.size(), kMaxArraysInFile);
  const Source bytes(zip_source_buffer_create(nullptr, 0, 0, nullptr));
  std::list<std::string> headers;  // until the archive is closed
  EGOSIEVE_ASSIGN_OR_RETURN(Archive archive, Open(bytes.get(), ZIP_CREATE | ZIP_TRUNCATE));
  uint64_t size = 0;
  for (const auto& [name, array] : arrays) {
    headers.push_back(NpyHeader(array));
    size += headers.back().size() + Elements(array).length;
    EGOSIEVE_REQUIRE(FailedPrecondition, size <= kMaximumBytes,
                     "array %s: the arrays would pass 4 GiB", name);
    EGOSIEVE_RETURN_IF_ERROR(
        AddMember(absl::StrCat(name, kSuffix), headers.back(), array, archive.get()));
  }
  if (zip_close(archive.get()) != 0) {
    return ZipError(absl::StatusCode::kInternal, "the archive", zip_get_error(archive.get()));
  }
  (void)archive.release();
  return BytesOf(bytes.get());
}

absl::StatusOr<ArrayMap> ParseArrays(std::string_view bytes) {
  const Source source(zip_source_buffer_create(bytes.data(), bytes.size(), 0, nullptr));
  EGOSIEVE_ASSIGN_OR_RETURN(const Archive archive, Open(source.get(), ZIP_RDONLY | ZIP_CHECKCONS));
  const int64_t count = zip_get_num_entries(archive.get(), 0);
  EGOSIEVE_REQUIRE(DataLoss, count >= 1 && count <= kMaxArraysInFile,
                   "%d members; from 1 to %d are read", count, kMaxArraysInFile);
  // Overlapping members would need more memory than the file.
  uint64_t left = bytes.size();
  ArrayMap arrays;
  for (int64_t i = 0; i < count; ++i) {
    zip_stat_t stat;
    if (zip_stat_index(archive.get(), i, 0, &stat) != 0) {
      return ZipError(absl::StatusCode::kDataLoss, absl::StrCat("member ", i),
                      zip_get_error(archive.get()));
    }
    EGOSIEVE_REQUIRE(Unimplemented,
                     stat.comp_method == ZIP_CM_STORE && stat.encryption_method == ZIP_EM_NONE,
                     "member %d is compressed or encrypted", i);
    EGOSIEVE_REQUIRE(DataLoss, stat.size <= left, "member %d: the members are larger than the file",
                     i);
    left -= stat.size;
    const std::string name = zip_get_name(archive.get(), i, ZIP_FL_ENC_RAW);
    EGOSIEVE_REQUIRE(DataLoss, name.size() > kSuffixSize && name.ends_with(kSuffix),
                     "member %d does not name an array", i);
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string data, ReadMember(archive.get(), i, stat.size));
    EGOSIEVE_ASSIGN_OR_RETURN(arrays[name.substr(0, name.size() - kSuffixSize)],
                              FromNpy(absl::StrCat(i), data));
  }
  return arrays;
}

}  // namespace egosieve::gp
