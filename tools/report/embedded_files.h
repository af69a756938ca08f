// Files that every report includes, with their contents at build time.
#ifndef EGOSIEVE_TOOLS_REPORT_EMBEDDED_FILES_H_
#define EGOSIEVE_TOOLS_REPORT_EMBEDDED_FILES_H_

namespace egosieve::tools {

extern const char kPageCss[];
extern const char kPageJs[];
extern const char kDygraphsCss[];
extern const char kDygraphsJs[];

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REPORT_EMBEDDED_FILES_H_
