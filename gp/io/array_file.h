// Named arrays in NumPy's .npz format, an uncompressed zip archive of .npy files. numpy.load reads
// files written here. Files of numpy.savez can be read here if their types and shapes are those
// below.
//
// Files may come from any source: every length is checked against the available bytes, and no
// allocation exceeds what the file's size justifies. Every array carries a CRC-32. The bytes depend
// on the contents and on the version of libzip alone (no times, no names of computers).
//
// Reference: numpy.lib.format, version 1.0. The archive is libzip's.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::gp {

// One or two dimensions, row-major; the number of elements is the product of the shape.
struct NamedArray {
  std::vector<int64_t> shape;
  std::variant<std::vector<double>, std::vector<int64_t>, std::vector<uint8_t>> elements;
};

template <typename T>
NamedArray VectorArray(std::vector<T> elements) {
  return {{static_cast<int64_t>(elements.size())}, std::move(elements)};
}

using ArrayMap = std::map<std::string, NamedArray>;

// The largest files that callers write hold 116 (tools/embed/c/segmenter_session.cc).
inline constexpr int64_t kMaxArraysInFile = 256;

// FailedPrecondition for no arrays, for more than can be read, and for more than 4 GiB.
absl::StatusOr<std::string> SerializeArrays(const ArrayMap& arrays);

// DataLoss, with reason and place, for bytes that are damaged, truncated or not such an archive;
// Unimplemented for members whose type, order or compression is not supported.
absl::StatusOr<ArrayMap> ParseArrays(std::string_view bytes);

}  // namespace egosieve::gp
