// Maps and masks are pictures: files, as the decoder gets them.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

#include "tools/run_folder/map_image.h"
#include "vision/frame/image_decoding.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string path = "/tmp/egosieve-picture-fuzz-" + std::to_string(getpid());
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return 0;
  std::fwrite(data, 1, size, file);
  std::fclose(file);
  egosieve::vision::DecodeImageFile(path).status().IgnoreError();
  egosieve::tools::ReadMap(path, {20, 12}, 1.0).status().IgnoreError();
  std::remove(path.c_str());
  return 0;
}
