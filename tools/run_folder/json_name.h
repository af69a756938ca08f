// Names of files in JSON, which holds UTF-8 alone, while names are any bytes.
#pragma once

#include <string>

#include "absl/strings/string_view.h"

namespace egosieve::tools {

// The name itself if it is UTF-8. Else each byte that is not, and each '%', as '%' and two
// hexadecimal digits: "stra%DFe.jpg".
std::string JsonName(absl::string_view name);

// The name of which JsonName made `text`. A file whose UTF-8 name has such an escape by itself is
// taken for the other one.
std::string NameFromJson(absl::string_view text);

}  // namespace egosieve::tools
