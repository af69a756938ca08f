// Non-owning view of an image of 8-bit pixels with 1 or 3 interleaved channels.
#pragma once

#include <cstddef>
#include <cstdint>

namespace egosieve::vision {

struct ImageView {
  const uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  int channels = 3;
  ptrdiff_t stride_bytes = 0;
};

}  // namespace egosieve::vision
