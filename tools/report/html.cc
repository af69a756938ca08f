#include "tools/report/html.h"

#include "absl/strings/str_replace.h"
#include "tools/report/embedded_files.h"

namespace egosieve::tools {

std::string EscapeHtml(absl::string_view text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

absl::string_view PageStyle() { return kPageCss; }

}  // namespace egosieve::tools
