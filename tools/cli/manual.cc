#include "tools/cli/manual.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"

namespace egosieve::tools {
namespace {

// Text with troff's special characters escaped; lists may break after their separators.
std::string Escaped(absl::string_view text) {
  std::string line = absl::StrReplaceAll(
      text, {{"\\", "\\e"}, {"-", "\\-"}, {"|", "|\\:"}, {",", ",\\:"}, {"\n", " "}});
  if (absl::StartsWith(line, ".") || absl::StartsWith(line, "'")) line.insert(0, "\\&");
  return line;
}

std::vector<std::string> NamesOf(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back(absl::StrCat("-", name));
  for (const std::string& name : option.get_lnames()) names.push_back(absl::StrCat("--", name));
  return names;
}

bool TakesValue(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

// The words that a flag accepts: those of a type such as "exact|sparse" or "FRAMES|auto", in which
// capitals stand for values.
std::vector<std::string> WordsOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  std::vector<std::string> words = absl::StrSplit(type, '|');
  if (words.size() < 2) return {};
  words.erase(std::remove_if(words.begin(), words.end(),
                             [](const std::string& word) {
                               return word.empty() || !absl::ascii_islower(word.front());
                             }),
              words.end());
  return words;
}

std::string FlagEntry(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  std::vector<std::string> names;
  for (const std::string& name : NamesOf(option)) {
    const bool with_value = TakesValue(option) && absl::StartsWith(name, "--");
    names.push_back(absl::StrCat(
        "\\fB", Escaped(name), "\\fR",
        with_value && !type.empty() ? absl::StrCat("=\\fI", Escaped(type), "\\fR") : ""));
  }
  std::string text = option.get_description();
  if (TakesValue(option) && !option.get_default_str().empty()) {
    absl::StrAppend(&text, " (", option.get_default_str(), ")");
  }
  if (!option.get_option_text().empty()) absl::StrAppend(&text, " ", option.get_option_text());
  return absl::StrCat(".TP\n", absl::StrJoin(names, ", "), "\n", Escaped(text), "\n");
}

std::string CommandSection(const std::string& program, const ManualCommand& command) {
  std::string arguments, positionals, flags;
  for (const CLI::Option* option : command.app->get_options()) {
    if (option->get_group().empty()) continue;  // not listed
    if (!option->get_positional()) {
      if (!NamesOf(*option).empty()) absl::StrAppend(&flags, FlagEntry(*option));
      continue;
    }
    const std::string name = option->get_name(/*positional=*/true);
    absl::StrAppend(&arguments, " ", option->get_required() ? name : absl::StrCat("[", name, "]"));
    absl::StrAppend(&positionals, ".TP\n.I ", Escaped(name), "\n",
                    Escaped(option->get_description()), "\n");
  }
  std::string section = absl::StrCat(".SS ", program, " ", command.name, Escaped(arguments), "\n",
                                     Escaped(command.summary), "\n", positionals, flags,
                                     ".PP\nExample:\n.PP\n.nf\n.RS\n");
  for (const absl::string_view line : absl::StrSplit(command.example, '\n')) {
    absl::StrAppend(&section, Escaped(line), "\n");
  }
  return absl::StrCat(section, ".RE\n.fi\n");
}

std::string FlagNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // not listed
    for (const std::string& name : option->get_lnames()) {
      names.push_back(absl::StrCat("--", name, TakesValue(*option) ? "=" : ""));
    }
  }
  return absl::StrJoin(names, " ");
}

}  // namespace

std::string ManualPage(const ManualProgram& program) {
  std::string page = absl::StrFormat(
      ".TH %s 1 \"\" \"%s %s\" \"User Commands\"\n.ad l\n.nh\n.SH NAME\n%s \\- %s\n.SH "
      "SYNOPSIS\n.B %s\n"
      "\\fICOMMAND\\fR [\\fIARGUMENTS\\fR]\n.SH COMMANDS\n",
      absl::AsciiStrToUpper(program.name), program.name, Escaped(program.version), program.name,
      Escaped(program.description), program.name);
  for (const ManualCommand& command : program.commands) {
    absl::StrAppend(&page, CommandSection(program.name, command));
  }
  absl::StrAppend(&page, ".SH EXIT STATUS\n");
  for (const auto& [code, text] : kExitCodeTexts) {
    absl::StrAppend(&page, ".TP\n.B ", code, "\n", Escaped(text), "\n");
  }
  return page;
}

std::string BashCompletion(const ManualProgram& program) {
  std::vector<std::string> commands;
  std::string values, flags;
  for (const ManualCommand& command : program.commands) {
    commands.push_back(command.name);
    absl::StrAppendFormat(&flags, "    \"%s\") flags=\"%s\" ;;\n", command.name,
                          FlagNames(*command.app));
    for (const CLI::Option* option : command.app->get_options()) {
      if (!TakesValue(*option)) continue;
      for (const std::string& name : option->get_lnames()) {
        absl::StrAppendFormat(&values, "    \"%s--%s\") takes_value=yes words=\"%s\" ;;\n",
                              command.name, name, absl::StrJoin(WordsOf(*option), " "));
      }
    }
  }
  // "=" separates words of COMP_WORDS, so --flag=w arrives as three words.
  return absl::StrFormat(R"(# Completion of %1$s for bash.
_%1$s() {
  local command=${COMP_WORDS[1]} current=${COMP_WORDS[COMP_CWORD]} flag= flags= words= takes_value=
  local previous=${COMP_WORDS[COMP_CWORD-1]}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    COMPREPLY=($(compgen -W "%2$s completion --help --man --version" -- "$current"))
    return
  fi
  case $current in
    =) flag=$previous current= ;;
    *) [[ $previous == = ]] && flag=${COMP_WORDS[COMP_CWORD-2]} || flag=$previous ;;
  esac
  case $command$flag in
%3$s  esac
  if [[ $takes_value ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
    return
  fi
  [[ $current == -* ]] || return
  case $command in
%4$s    completion) flags= ;;
  esac
  COMPREPLY=($(compgen -W "$flags" -- "$current"))
  [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *= ]] && compopt -o nospace
}
complete -o default -F _%1$s %1$s
)",
                         program.name, absl::StrJoin(commands, " "), values, flags);
}

}  // namespace egosieve::tools
