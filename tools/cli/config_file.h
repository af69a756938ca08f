// The file of --config: TOML, whose keys are the names of a command's flags.
#ifndef EGOSIEVE_TOOLS_CLI_CONFIG_FILE_H_
#define EGOSIEVE_TOOLS_CLI_CONFIG_FILE_H_

#include <CLI/CLI.hpp>
#include <istream>
#include <vector>

namespace egosieve::tools {

// Reads by toml_entries.h, writes as CLI11 does. What is no TOML is a CLI::FileError whose message
// names the line.
class ConfigFile : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_CONFIG_FILE_H_
