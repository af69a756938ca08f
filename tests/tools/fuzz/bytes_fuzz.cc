// What is read from bytes, and written again where it was read. BUILD says what: FUZZED.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gp/io/array_file.h"
#include "gp/io/model_file.h"
#include "tools/batch/drives.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"

namespace egosieve::fuzz {

void arrays(std::string_view bytes) {
  const auto read = gp::ParseArrays(bytes);
  if (read.ok() && !gp::SerializeArrays(*read).ok()) __builtin_trap();
}
void model(std::string_view bytes) {
  const auto read = gp::ParseModel(bytes);
  if (read.ok() && !gp::SerializeModel(*read).ok()) __builtin_trap();
}
void frame_line(std::string_view bytes) {
  const auto read = tools::FrameLineFromText({bytes.data(), bytes.size()});
  if (read.ok()) tools::ToText(*read);
}
void run_description(std::string_view bytes) {
  const auto read = tools::RunDescriptionFromText({bytes.data(), bytes.size()});
  if (read.ok()) tools::ToText(*read);
}
void manifest(std::string_view bytes) {
  tools::ParseManifest({bytes.data(), bytes.size()}, "/drives").IgnoreError();
}

}  // namespace egosieve::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  egosieve::fuzz::FUZZED({reinterpret_cast<const char*>(data), size});
  return 0;
}
