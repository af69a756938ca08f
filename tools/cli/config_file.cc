#include "tools/cli/config_file.h"

#include <CLI/CLI.hpp>
#include <iterator>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tools/cli/research_flag.h"
#include "tools/cli/toml_entries.h"

namespace egosieve::tools {

std::vector<CLI::ConfigItem> ConfigFile::from_config(std::istream& input) const {
  const std::string text((std::istreambuf_iterator<char>(input)), std::istreambuf_iterator<char>());
  const absl::StatusOr<std::vector<TomlEntry>> entries = ReadTomlEntries(text);
  if (!entries.ok()) {
    throw CLI::FileError(
        absl::StrCat("the file of --config is no TOML: ", std::string(entries.status().message())),
        CLI::ExitCodes::FileError);
  }
  std::vector<CLI::ConfigItem> items;
  for (const TomlEntry& entry : *entries) {
    if (entry.values.empty()) continue;  // []: not given
    CLI::ConfigItem item;
    item.parents.assign(entry.path.begin(), entry.path.end() - 1);
    item.name = absl::StrReplaceAll(entry.path.back(), {{"-", "_"}});
    if (item.parents == std::vector<std::string>{kResearchTable}) {
      item.parents.clear();
      item.name = absl::StrCat(kResearchTable, ".", item.name);
    }
    item.inputs = entry.values;
    items.push_back(item);
  }
  return items;
}

}  // namespace egosieve::tools
