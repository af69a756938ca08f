#include "tools/cli/result_flag.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

namespace egosieve::tools {

void ResultFlag::AddFlag(CLI::App& app) {
  app.add_flag("--json", json, "Print the result as a line of JSON");
}

void ResultFlag::Tell(const std::string& command, const nlohmann::ordered_json& fields,
                      const std::string& text) const {
  if (quiet) return;
  if (!json) {
    std::cout << text;
    return;
  }
  nlohmann::ordered_json result = {{"command", command}, {"schema_version", kResultSchemaVersion}};
  result.update(fields);
  // A file's name may hold bytes that are not UTF-8.
  std::cout << result.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
            << "\n";
}

}  // namespace egosieve::tools
