// Files that every report includes, with their contents at build time.
#pragma once

namespace egosieve::tools {

extern const char kPageCss[];
extern const char kPageJs[];
extern const char kDygraphsCss[];
extern const char kDygraphsJs[];

}  // namespace egosieve::tools
