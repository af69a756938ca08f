#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tools/run_folder/frame_line.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto line = egosieve::tools::FrameLineFromText({bytes.data(), bytes.size()});
  if (line.ok()) egosieve::tools::ToText(*line);
  return 0;
}
