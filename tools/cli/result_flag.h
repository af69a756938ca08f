// The flag --json: a command prints its result at the end as one line of JSON instead of text. The
// field "command" has the command's name. tools/schema/result.schema.json lists the fields. Errors
// and warnings stay on stderr.
#ifndef EGOSIEVE_TOOLS_CLI_RESULT_FLAG_H_
#define EGOSIEVE_TOOLS_CLI_RESULT_FLAG_H_

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

namespace egosieve::tools {

// Version of result.schema.json; raised when readers of the previous form would misread the result.
inline constexpr int kResultSchemaVersion = 1;

struct ResultFlag {
  bool json = false;

  void AddFlag(CLI::App& app) {
    app.add_flag("--json", json, "Print the result as a line of JSON");
  }

  // fields: an object. text: the result as text, with its line breaks.
  void Tell(const std::string& command, const nlohmann::ordered_json& fields,
            const std::string& text) const {
    if (!json) {
      std::cout << text;
      return;
    }
    nlohmann::ordered_json result = {{"command", command},
                                     {"schema_version", kResultSchemaVersion}};
    result.update(fields);
    // A file's name may hold bytes that are not UTF-8.
    std::cout << result.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
              << "\n";
  }
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_RESULT_FLAG_H_
