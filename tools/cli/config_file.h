// The file of --config: TOML with the names of a command's flags as keys.
#ifndef EGOSIEVE_TOOLS_CLI_CONFIG_FILE_H_
#define EGOSIEVE_TOOLS_CLI_CONFIG_FILE_H_

#include <CLI/CLI.hpp>
#include <istream>
#include <vector>

namespace egosieve::tools {

// Reads by toml_entries.h, writes as CLI11 does. Text that is not TOML is a CLI::FileError; its
// message names the line.
class ConfigFile : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_CONFIG_FILE_H_
