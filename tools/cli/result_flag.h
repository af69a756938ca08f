// The flag --json: a command prints its result at the end as one line of JSON instead of text. The
// field "command" has the command's name. tools/schema/result.schema.json lists the fields. Errors
// and warnings stay on stderr.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace CLI {
class App;
}

namespace egosieve::tools {

// Version of result.schema.json; raised when readers of the previous form would misread the result.
inline constexpr int kResultSchemaVersion = 1;

struct ResultFlag {
  bool json = false;
  bool quiet = false;  // prints nothing: for commands within another one

  void AddFlag(CLI::App& app);

  // fields: an object. text: the result as text, with its line breaks.
  void Tell(const std::string& command, const nlohmann::ordered_json& fields,
            const std::string& text) const;
};

}  // namespace egosieve::tools
