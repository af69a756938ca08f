#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tools/batch/drives.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  egosieve::tools::ParseManifest({bytes.data(), bytes.size()}, "/drives").IgnoreError();
  return 0;
}
