// What the program's pages share.
#ifndef EGOSIEVE_TOOLS_REPORT_HTML_H_
#define EGOSIEVE_TOOLS_REPORT_HTML_H_

#include <string>

#include "absl/strings/string_view.h"

namespace egosieve::tools {

// Text as it must be written between tags or in an attribute.
std::string EscapeHtml(absl::string_view text);

// Their style sheet, page.css.
absl::string_view PageStyle();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REPORT_HTML_H_
