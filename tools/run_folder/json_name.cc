#include "tools/run_folder/json_name.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Bytes of the character at the beginning; 0 if it is not UTF-8 (RFC 3629: shortest form, no
// surrogates, at most U+10FFFF).
size_t CharacterSize(absl::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t lead = byte(0);
  const size_t size = lead < 0x80 ? 1 : lead < 0xc2 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  if (size == 0 || lead > 0xf4 || size > text.size()) return 0;
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool is_wrong = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xed && byte(1) > 0x9f) ||
                        (lead == 0xf0 && byte(1) < 0x90) || (lead == 0xf4 && byte(1) > 0x8f);
  return is_wrong ? 0 : size;
}

bool IsUtf8(absl::string_view text) {
  for (size_t place = 0, size = 0; place < text.size(); place += size) {
    size = CharacterSize(text.substr(place));
    if (size == 0) return false;
  }
  return true;
}

}  // namespace

std::string JsonName(absl::string_view name) {
  if (IsUtf8(name)) return std::string(name);
  std::string text;
  while (!name.empty()) {
    const size_t size = name[0] == '%' ? 0 : CharacterSize(name);
    if (size == 0) {
      absl::StrAppendFormat(&text, "%%%02X", static_cast<uint8_t>(name[0]));
    } else {
      text.append(name.data(), size);
    }
    name.remove_prefix(size == 0 ? 1 : size);
  }
  return text;
}

std::string NameFromJson(absl::string_view text) {
  std::string name;
  for (size_t place = 0; place < text.size(); ++place) {
    uint32_t byte = 0;
    if (text[place] == '%' && absl::SimpleHexAtoi(text.substr(place + 1, 2), &byte)) {
      name.push_back(static_cast<char>(byte));
      place += 2;
    } else {
      name.push_back(text[place]);
    }
  }
  return JsonName(name) == text ? name : std::string(text);
}

}  // namespace egosieve::tools
