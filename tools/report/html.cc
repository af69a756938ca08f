#include "tools/report/html.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tools/report/embedded_files.h"

namespace egosieve::tools {

std::string EscapeHtml(absl::string_view text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

absl::string_view PageStyle() { return kPageCss; }

std::string PageHead(absl::string_view title, absl::string_view style,
                     absl::string_view further_head) {
  return absl::StrCat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n",
      further_head, "<title>", EscapeHtml(title), "</title>\n<style>\n", style,
      "</style>\n</head>\n<body>\n");
}

}  // namespace egosieve::tools
