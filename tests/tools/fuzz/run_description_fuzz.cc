#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tools/run_folder/run_description.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto description = egosieve::tools::RunDescriptionFromText({bytes.data(), bytes.size()});
  if (description.ok()) egosieve::tools::ToText(*description);
  return 0;
}
