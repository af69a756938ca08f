// Named arrays in NumPy's .npz format: an uncompressed zip archive of .npy files. numpy.load reads
// what this writes; this reads what numpy.savez writes, within the types and shapes below.
//
// The format was chosen over HDF5 because a strict reader of it is small: files may come from
// anywhere, every length is checked against the bytes that are there, and no allocation exceeds
// what the file's size justifies. Every array carries a CRC-32. Bytes depend on the
// contents alone (no times, no names of machines).
//
// Reference: numpy.lib.format, version 1.0; PKWARE APPNOTE 6.3.3, without zip64.
#ifndef EGOSIEVE_GP_IO_ARRAY_FILE_H_
#define EGOSIEVE_GP_IO_ARRAY_FILE_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::gp {

// One or two dimensions, row-major; the elements' count is the product of the shape.
struct NamedArray {
  std::vector<int64_t> shape;
  std::variant<std::vector<double>, std::vector<int64_t>, std::vector<uint8_t>> elements;
};

using ArrayMap = std::map<std::string, NamedArray>;

inline constexpr int64_t kMaxArraysInFile = 64;

// FailedPrecondition where the archive would pass 4 GiB, zip's limit.
absl::StatusOr<std::string> SerializeArrays(const ArrayMap& arrays);

// DataLoss, saying what and where, for bytes that are damaged, truncated or not such an archive;
// Unimplemented for members whose type, order or compression this does not read.
absl::StatusOr<ArrayMap> ParseArrays(std::string_view bytes);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_IO_ARRAY_FILE_H_
