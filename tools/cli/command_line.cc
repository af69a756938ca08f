#include "tools/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <istream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "kernels/base/exception_status.h"
#include "tools/cli/interruption.h"
#include "tools/cli/research_flag.h"
#include "tools/cli/toml_entries.h"

namespace egosieve::tools {
namespace {

// The file of --config: TOML with the names of a command's flags as keys.

// Reads by toml_entries.h, writes as CLI11 does. Text that is not TOML is a CLI::FileError; its
// message names the line.
class ConfigFile : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;
};

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

// Names of flags with underscores, and a research setting as the flag that it is to CLI11.
void Unify(const CLI::App& app, std::vector<std::string>& arguments) {
  const bool has_settings = app.get_option_no_throw(kSetFlag) != nullptr;
  for (size_t i = 0; i < arguments.size() && arguments[i] != "--"; ++i) {
    std::string& argument = arguments[i];
    if (!absl::StartsWith(argument, "--")) continue;
    std::replace(argument.begin() + 2, std::find(argument.begin(), argument.end(), '='), '-', '_');
    if (!has_settings || argument.substr(0, argument.find('=')) != kSetFlag) continue;
    if (argument == kSetFlag) {
      if (i + 1 == arguments.size() || absl::StartsWith(arguments[i + 1], "-")) continue;
      argument = absl::StrCat(kSetFlag, "=", arguments[i + 1]);
      arguments.erase(arguments.begin() + i + 1);
    }
    const std::string setting = arguments[i].substr(std::string(kSetFlag).size() + 1);
    arguments[i] = absl::StrCat(kResearchFlag, setting, absl::StrContains(setting, '=') ? "" : "=");
  }
}

// An error message; "" if every given flag is known.
std::string DescribeUnknownFlag(const CLI::App& app) {
  for (const std::string& argument : app.remaining()) {
    if (absl::StartsWith(argument, "-")) {
      return absl::StrCat("unknown flag ", argument.substr(0, argument.find('=')), "; ");
    }
  }
  return "";
}

// The first flag that needs a value and was given without one; "" if there is none. CLI11 would
// take the next argument as its value, even if that is a flag.
std::string FlagWithoutValue(const CLI::App& app, const std::vector<std::string>& arguments) {
  for (size_t i = 0; i < arguments.size() && arguments[i] != "--"; ++i) {
    const std::string name = arguments[i].substr(0, arguments[i].find('='));
    if (!absl::StartsWith(name, "--")) continue;
    const CLI::Option* const option = app.get_option_no_throw(name);
    if (option == nullptr || option->get_items_expected_max() == 0) continue;
    const bool follows = name == arguments[i];
    if (!follows && name.size() + 1 < arguments[i].size()) continue;
    if (!follows || i + 1 == arguments.size() || absl::StartsWith(arguments[i + 1], "--")) {
      return name;
    }
    ++i;
  }
  return "";
}

// CLI11's messages; in other words where they name what the user did not write.
std::string DescribeParseError(const CLI::App& app, const CLI::ParseError& error) {
  const bool is_extra = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  // A missing flag may be misspelt: report the unknown flag rather than the missing one.
  if (is_extra || dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    if (std::string unknown = DescribeUnknownFlag(app); !unknown.empty()) return unknown;
  }
  if (is_extra) return absl::StrCat("unexpected argument '", app.remaining().front(), "'; ");
  const absl::string_view message = error.what();
  if (dynamic_cast<const CLI::ConfigError*>(&error) != nullptr) {
    const std::string key(absl::StripPrefix(message, "INI was not able to parse "));
    if (app.get_option_no_throw(kResearchFlag + key) != nullptr) {
      return absl::StrCat("'", key,
                          "' in the file of --config is a research setting: put it under [",
                          kResearchTable, "]; ");
    }
    return absl::StrCat("unknown key '", key, "' in the file of --config; ");
  }
  return absl::StrCat(message, "; ");
}

// The flags as a file for --config, without those that have no value. The table of research settings
// tells all; those that are not given are comments.
std::string ConfigText(const CLI::App& app) {
  const std::string key = absl::StrCat("\n", kResearchTable, ".");
  std::string text, research;
  for (const absl::string_view entry : absl::StrSplit(
           app.config_to_str(/*default_also=*/true, /*write_description=*/true), "\n\n")) {
    const absl::string_view line = absl::StripAsciiWhitespace(entry);
    // An empty list is [] to CLI11 2.3 and {} to 2.4.
    if (absl::EndsWith(line, " Options")) continue;  // a group's heading
    if (!absl::EndsWith(line, "=\"\"") && !absl::EndsWith(line, "=\"[]\"") &&
        !absl::EndsWith(line, "=\"{}\"")) {
      const size_t place = line.find(key);
      if (place == line.npos) {
        absl::StrAppend(&text, line, "\n\n");
        continue;
      }
      const std::string setting(line.substr(place + key.size()));
      const std::string flag = kResearchFlag + setting.substr(0, setting.find('='));
      absl::StrAppend(&research, "\n", line.substr(0, place),
                      app.get_option(flag)->count() > 0 ? "\n" : "\n# ", setting, "\n");
    }
  }
  return research.empty() ? text : absl::StrCat(text, "[", kResearchTable, "]\n", research);
}

// Reading a pipe would block until something is written to it.
CLI::Validator NoPipe() {
  return CLI::Validator(
      [](std::string& path) {
        std::error_code error;
        const std::filesystem::file_status status = std::filesystem::status(path, error);
        return !std::filesystem::exists(status) || std::filesystem::is_regular_file(status)
                   ? std::string()
                   : absl::StrCat(path, " is no regular file");
      },
      "");
}

// A research setting by the name that its user gave.
std::string AsSetFlag(const std::string& message) {
  return absl::StrReplaceAll(message, {{kResearchFlag, absl::StrCat(kSetFlag, " ")}});
}

std::string Indented(const std::string& lines) {
  return absl::StrCat("  ", absl::StrReplaceAll(lines, {{"\n", "\n  "}}));
}

// The command's flags, and those that every command has.
void AddAllFlags(Command& command, CLI::App& app, bool& print_config) {
  app.option_defaults()->always_capture_default();
  command.AddFlags(app);
  app.set_help_flag("-h,--help", "Print this text and exit");
  app.config_formatter(std::make_shared<ConfigFile>());
  app.set_config("--config", "",
                 "Read flags from a TOML file; flags of the command line override it")
      ->type_name("FILE")
      ->check(NoPipe());
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.add_flag("--print_config", print_config,
               "Print the flags that have a value as a file for --config and exit")
      ->configurable(false);
  app.footer(absl::StrCat("Example:\n", Indented(command.example())));
}

}  // namespace

CommandLine::CommandLine(std::string program, std::string description, std::string version,
                         std::string build)
    : program_(std::move(program)),
      description_(std::move(description)),
      version_(std::move(version)),
      build_(std::move(build)) {}

void CommandLine::Add(std::unique_ptr<Command> command) { commands_.push_back(std::move(command)); }

std::string CommandLine::Help() const {
  size_t width = 0;
  for (const auto& command : commands_) width = std::max(width, command->name().size());
  std::string help =
      absl::StrCat(description_, "\n\nUsage: ", program_, " COMMAND ...\n\nCommands:\n");
  for (const auto& command : commands_) {
    absl::StrAppendFormat(&help, "  %-*s  %s\n", static_cast<int>(width), command->name(),
                          command->summary());
  }
  absl::StrAppend(&help, "\n", program_,
                  " COMMAND --help lists a command's flags, with an example.\n", program_,
                  " --man prints the manual page, ", program_,
                  " completion bash what bash sources for completion.\n\nExit codes:\n");
  for (const auto& [code, text] : kExitCodeTexts) {
    absl::StrAppendFormat(&help, "  %-3d  %s\n", code, text);
  }
  return help;
}

std::string CommandLine::WriteManual(std::string (*write)(const ManualProgram&)) {
  ManualProgram manual{program_, description_, version_, {}};
  std::vector<std::unique_ptr<CLI::App>> apps;
  bool print_config = false;
  for (const auto& command : commands_) {
    apps.push_back(std::make_unique<CLI::App>(command->summary(), command->name()));
    AddAllFlags(*command, *apps.back(), print_config);
    HideSettings(*apps.back());
    manual.commands.push_back(
        {command->name(), command->summary(), command->example(), apps.back().get()});
  }
  return write(manual);
}

int CommandLine::TellCompletion(const std::vector<std::string>& arguments, std::ostream& out,
                                std::ostream& err) {
  if (arguments != std::vector<std::string>{"completion", "bash"}) {
    err << ErrorLine(absl::StrCat("completion takes the name of the shell, and bash is the one it "
                                  "knows; source <(",
                                  program_, " completion bash)"))
        << "\n";
    return static_cast<int>(ExitCode::kUsage);
  }
  out << WriteManual(BashCompletion);
  return static_cast<int>(ExitCode::kDone);
}

int CommandLine::Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err) {
  const int code = Dispatch(std::move(arguments), out, err);
  out.flush();
  if (out) return code;
  err << ErrorLine(
             "cannot write all of the results to stdout; see that it is open and that its "
             "disk is not full")
      << "\n";
  return code == static_cast<int>(ExitCode::kDone) ? static_cast<int>(ExitCode::kEnvironment)
                                                   : code;
}

int CommandLine::Dispatch(std::vector<std::string> arguments, std::ostream& out,
                          std::ostream& err) {
  const std::string first = arguments.empty() ? "" : PresentName(arguments.front());
  if (first == "--version" || first == "version") {
    out << program_ << " " << version_ << (build_.empty() ? "" : ", ") << build_ << "\n";
    return static_cast<int>(ExitCode::kDone);
  }
  if (first == "--man") {
    out << WriteManual(ManualPage);
    return static_cast<int>(ExitCode::kDone);
  }
  if (first == "completion") return TellCompletion(arguments, out, err);
  if (arguments.empty()) {
    err << Help();
    return static_cast<int>(ExitCode::kUsage);
  }
  if (first == "--help" || first == "-h" || first == "help") {
    out << Help();
    return static_cast<int>(ExitCode::kDone);
  }
  arguments.erase(arguments.begin());
  for (const auto& command : commands_) {
    if (command->name() == first) {
      return RunCommand(*command, absl::StrCat(program_, " ", first), std::move(arguments), out,
                        err);
    }
  }
  err << ErrorLine(absl::StrCat(absl::StartsWith(first, "-") ? "unknown flag " : "unknown command ",
                                first, "; see ", program_, " --help"))
      << "\n";
  return static_cast<int>(ExitCode::kUsage);
}

int CommandLine::RunCommand(Command& command, const std::string& name,
                            std::vector<std::string> arguments, std::ostream& out,
                            std::ostream& err) {
  CLI::App app(command.summary(), name);
  bool print_config = false;
  AddAllFlags(command, app, print_config);

  Unify(app, arguments);
  if (std::find(arguments.begin(), arguments.end(), "--print_config") != arguments.end()) {
    for (CLI::Option* option : app.get_options()) {
      option->required(false);
    }
  }

  if (const std::string flag = FlagWithoutValue(app, arguments); !flag.empty()) {
    err << ErrorLine(AsSetFlag(absl::StrCat(flag, " has no value; give one as ", flag,
                                            "=VALUE; see ", name, " --help")))
        << "\n";
    return static_cast<int>(ExitCode::kUsage);
  }
  try {
    std::reverse(arguments.begin(), arguments.end());
    app.parse(std::move(arguments));
    if (print_config) {
      out << ConfigText(app);
      return static_cast<int>(ExitCode::kDone);
    }
    const absl::StatusOr<ExitCode> result = command.Run();
    if (result.ok()) {
      return static_cast<int>(*result);
    }
    const absl::Status status =
        IsInterruption(result.status()) ? absl::CancelledError("interrupted") : result.status();
    err << ErrorLine(status.message()) << "\n";
    return static_cast<int>(ExitCodeForStatus(status));
  } catch (const CLI::CallForHelp&) {
    HideSettings(app);
    // CLI11 marks names that turn a flag off.
    out << absl::StrReplaceAll(app.help(), {{"{false}", ""}});
    return static_cast<int>(ExitCode::kDone);
  } catch (const CLI::ParseError& error) {
    err << ErrorLine(
               absl::StrCat(AsSetFlag(DescribeParseError(app, error)), "see ", name, " --help"))
        << "\n";
    return static_cast<int>(ExitCode::kUsage);
  } catch (...) {
    err << ErrorLine(kernels::CurrentExceptionStatus().message()) << "\n";
    return static_cast<int>(ExitCode::kEnvironment);
  }
}

}  // namespace egosieve::tools
