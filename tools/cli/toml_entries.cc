#include "tools/cli/toml_entries.h"

// Texts such as "[:]" violate toml++'s assertions; the code below then refuses them. Without this
// definition the assertions would end the program, or with NDEBUG be assumptions of the compiler.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_cast<void>(0)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

// The shortest text that reads back as the same number.
std::string Shortest(double number) {
  char digits[32];
  return std::string(digits, std::to_chars(digits, digits + sizeof(digits), number).ptr);
}

struct Placed {
  TomlEntry entry;
  toml::source_position place;
};

absl::Status Refused(const toml::node& node, const std::string& name) {
  return absl::InvalidArgumentError(absl::StrCat("line ", node.source().begin.line, ": '", name,
                                                 "' is neither a text, a number, true or false, "
                                                 "nor a list of these"));
}

bool AddValue(const toml::node& node, TomlEntry& entry) {
  if (const auto* text = node.as_string()) {
    entry.values.push_back(text->get());
  } else if (const auto* whole = node.as_integer()) {
    entry.values.push_back(absl::StrCat(whole->get()));
  } else if (const auto* number = node.as_floating_point()) {
    entry.values.push_back(Shortest(number->get()));
  } else if (const auto* yes = node.as_boolean()) {
    entry.values.push_back(yes->get() ? "true" : "false");
  } else {
    return false;
  }
  return true;
}

absl::Status AddTable(const toml::table& table, const std::vector<std::string>& path,
                      std::vector<Placed>& entries);

absl::Status AddNode(const toml::node& node, const std::vector<std::string>& path,
                     std::vector<Placed>& entries) {
  if (const auto* table = node.as_table()) return AddTable(*table, path, entries);
  Placed placed{{path, {}, node.is_array(), static_cast<int>(node.source().begin.line)},
                node.source().begin};
  const auto* array = node.as_array();
  if (array == nullptr) {
    if (!AddValue(node, placed.entry)) return Refused(node, path.back());
    entries.push_back(std::move(placed));
    return absl::OkStatus();
  }
  for (const toml::node& element : *array) {
    if (!AddValue(element, placed.entry)) return Refused(element, path.back());
  }
  entries.push_back(std::move(placed));
  return absl::OkStatus();
}

absl::Status AddTable(const toml::table& table, const std::vector<std::string>& path,
                      std::vector<Placed>& entries) {
  std::vector<std::string> below = path;
  below.emplace_back();
  for (const auto& [key, node] : table) {
    below.back() = std::string(key.str());
    EGOSIEVE_RETURN_IF_ERROR(AddNode(node, below, entries));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<TomlEntry>> ReadTomlEntries(absl::string_view text) {
  toml::table table;
  try {
    table = toml::parse(std::string_view(text.data(), text.size()));
  } catch (const toml::parse_error& error) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", error.source().begin.line, ": ", std::string(error.description())));
  }
  std::vector<Placed> placed;
  EGOSIEVE_RETURN_IF_ERROR(AddTable(table, {}, placed));
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return std::tie(a.place.line, a.place.column) < std::tie(b.place.line, b.place.column);
  });
  std::vector<TomlEntry> entries;
  for (Placed& one : placed) entries.push_back(std::move(one.entry));
  return entries;
}

}  // namespace egosieve::tools
