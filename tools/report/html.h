// HTML that the program's pages share.
#pragma once

#include <string>

#include "absl/strings/string_view.h"

namespace egosieve::tools {

// Text escaped for use between tags or in an attribute.
std::string EscapeHtml(absl::string_view text);

// The style sheet of reports and batches, page.css.
absl::string_view PageStyle();

// From the document type to <body>. title: plain text; style: CSS; further_head: HTML.
std::string PageHead(absl::string_view title, absl::string_view style,
                     absl::string_view further_head = "");

}  // namespace egosieve::tools
