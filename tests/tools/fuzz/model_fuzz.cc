#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gp/io/model_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto model = egosieve::gp::ParseModel(bytes);
  if (model.ok() && !egosieve::gp::SerializeModel(*model).ok()) __builtin_trap();
  return 0;
}
