// The flag --json: what a command prints at its end, as one line of JSON with its name in the field
// "command" instead of text for people. tools/schema/result.schema.json has the fields. Errors
// and warnings stay on stderr.
#ifndef EGOSIEVE_TOOLS_CLI_RESULT_FLAG_H_
#define EGOSIEVE_TOOLS_CLI_RESULT_FLAG_H_

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

namespace egosieve::tools {

// Of result.schema.json; grows where a reader of the old form would be wrong.
inline constexpr int kResultSchemaVersion = 1;

struct ResultFlag {
  bool json = false;

  void AddFlag(CLI::App& app) {
    app.add_flag("--json", json, "Print the result as a line of JSON");
  }

  // fields: an object. text: the same with its line breaks.
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
