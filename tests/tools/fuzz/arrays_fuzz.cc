#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gp/io/array_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto arrays = egosieve::gp::ParseArrays(bytes);
  if (arrays.ok() && !egosieve::gp::SerializeArrays(*arrays).ok()) __builtin_trap();
  return 0;
}
