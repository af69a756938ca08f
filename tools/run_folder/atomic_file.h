// Functions of kernels/files/atomic_file.h in this namespace, and files read by their text.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::tools {

using kernels::CreateFolder;
using kernels::ListFolder;
using kernels::ReadFile;
using kernels::WriteFileAtomically;

// parse: an absl::StatusOr of the file's text. Its errors get the file's name.
template <typename Parse>
auto ParseFile(const std::string& path, Parse parse) -> decltype(parse("")) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  auto parsed = parse(text);
  if (parsed.ok()) return parsed;
  return absl::Status(parsed.status().code(), absl::StrCat(path, ": ", parsed.status().message()));
}

}  // namespace egosieve::tools
