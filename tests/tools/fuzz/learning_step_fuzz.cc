#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "vision/segmentation/learning_step.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto step =
      egosieve::vision::ParseStep(bytes, egosieve::kernels::CovarianceFunction::kArcsine, 6);
  if (step.ok() && !egosieve::vision::SerializeStep(*step).ok()) __builtin_trap();
  return 0;
}
