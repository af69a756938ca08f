// The folder of a command's output where --out is not given.
#pragma once

#include <filesystem>
#include <string>

namespace egosieve::tools {

// out/NAME: the input's name without extension; of a glob, the name of its folder.
inline std::string DefaultFolder(const std::string& input) {
  std::filesystem::path path = std::filesystem::absolute(input).lexically_normal();
  while (path.has_relative_path() &&
         (path.filename().empty() ||
          path.filename().string().find_first_of("*?[") != std::string::npos)) {
    path = path.parent_path();
  }
  return "out/" + path.stem().string();
}

}  // namespace egosieve::tools
