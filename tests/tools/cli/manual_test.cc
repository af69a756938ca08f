// The manual page and bash's completion of the program itself, read by troff and by bash.
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

std::vector<std::string> Words(const std::string& text) {
  return absl::StrSplit(text, absl::ByAnyChar(" \n"), absl::SkipEmpty());
}

std::vector<std::string> Lines(const std::string& text) { return absl::StrSplit(text, '\n'); }

ProgramOutcome RunWords(const std::string& command, const std::vector<std::string>& flags) {
  std::vector<std::string> arguments = Words(command);
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  return RunProgram(arguments);
}

// Flags of a command's --help, "--no_noise" and the like included.
std::vector<std::string> FlagsInHelp(const std::string& command) {
  std::vector<std::string> flags;
  for (const std::string& line : Lines(RunWords(command, {"--help"}).out)) {
    if (line.rfind("  -", 0) != 0) continue;
    const std::vector<std::string> names = absl::StrSplit(Words(line).front(), ',');
    for (const std::string& name : names) {
      if (name.rfind("--", 0) == 0) flags.push_back(name.substr(0, name.find('{')));
    }
  }
  return flags;
}

// All commands, as the program's help lists them.
std::vector<std::string> Commands() {
  std::vector<std::string> commands;
  bool within = false;
  for (const std::string& line : Lines(RunProgram({"--help"}).out)) {
    if (line == "Commands:") {
      within = true;
    } else if (within && line.empty()) {
      break;
    } else if (within) {
      commands.push_back(Words(line).front());
    }
  }
  return commands;
}

class Completion : public testing::Test {
 protected:
  Completion() : script_(FreshFolder() + "/completion.bash") {
    const ProgramOutcome outcome = RunProgram({"completion", "bash"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_TRUE(WriteFileAtomically(script_, outcome.out).ok());
  }

  // What bash offers for the last of the words, as it splits the line. compopt works only while a
  // line is being edited.
  std::vector<std::string> Of(const std::string& words) const {
    return Words(ShellOutput(
        absl::StrCat("bash -c 'compopt() { :; }; . ", script_, "; COMP_WORDS=(egosieve ", words,
                     "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _egosieve; printf "
                     "\"%s\\n\" \"${COMPREPLY[@]}\"' 2>&1")));
  }

  std::string script_;
};

TEST_F(Completion, OfCommands) {
  EXPECT_THAT(Of("\"\""), IsSupersetOf(Commands()));
  EXPECT_THAT(Of("refi"), ElementsAre("refine"));
}

TEST_F(Completion, OfEveryFlagInHelp) {
  for (const std::string& command : Commands()) {
    std::set<std::string> offered;
    for (const std::string& flag : Of(command + " --")) {
      offered.insert(flag.substr(0, flag.find('=')));
    }
    EXPECT_THAT(offered, IsSupersetOf(FlagsInHelp(command))) << command;
  }
  EXPECT_THAT(Of("segment --out"), ElementsAre("--out="));
  EXPECT_THAT(Of("segment --resu"), ElementsAre("--resume"));
}

TEST_F(Completion, OfAFlagsWords) {
  EXPECT_THAT(Of("segment --profile ="), ElementsAre("default", "paper", "fast"));
  EXPECT_THAT(Of("segment --profile = pa"), ElementsAre("paper"));
  EXPECT_THAT(Of("segment --profile pa"), ElementsAre("paper"));
  EXPECT_THAT(Of("masks --for = co"), ElementsAre("colmap", "coco"));
}

// bash goes on with files.
TEST_F(Completion, LeavesFilesToBash) {
  EXPECT_THAT(Of("segment --out = x"), IsEmpty());
  EXPECT_THAT(Of("segment dri"), IsEmpty());
  EXPECT_THAT(Of("segment --resume dri"), IsEmpty());
}

TEST(CompletionCommand, NamesTheShellsItKnows) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"completion"}, {"completion", "zsh"}}) {
    EXPECT_THAT(RunProgram(arguments), EndsWithLine(2, "bash is the one it knows"));
  }
}

TEST(Config, OfEveryCommandIsReadAgain) {
  const std::string path = FreshFolder() + "/config.toml";
  int switches = 0;
  for (const std::string& command : Commands()) {
    const ProgramOutcome printed = RunWords(command, {"--print_config"});
    ASSERT_EQ(printed.code, 0) << command;
    ASSERT_TRUE(WriteFileAtomically(path, printed.out).ok());
    EXPECT_EQ(RunWords(command, {"--config=" + path, "--print_config"}).out, printed.out);
    // A flag that has a second name to turn it off is on.
    for (const std::string& line : Lines(RunWords(command, {"--help"}).out)) {
      EXPECT_FALSE(absl::StrContains(line, "{false}")) << line;
      if (!absl::StrContains(line, ",--") || !absl::StrContains(line, "(default: on)")) continue;
      const std::string word = Words(line).front();
      const std::string name = word.substr(2, word.find(',') - 2);
      EXPECT_THAT(printed.out, HasSubstr(absl::StrCat("\n", name, "=true\n"))) << command;
      ++switches;
    }
  }
  EXPECT_EQ(switches, 8);
}

TEST(Manual, TellsEveryCommandAndFlagWithoutTroffsWarnings) {
  const std::string path = FreshFolder() + "/egosieve.1";
  const ProgramOutcome outcome = RunProgram({"--man"});
  ASSERT_EQ(outcome.code, 0);
  ASSERT_TRUE(WriteFileAtomically(path, outcome.out).ok());
  if (ShellOutput("command -v groff").empty()) GTEST_SKIP() << "there is no groff";
  EXPECT_EQ(ShellOutput("groff -man -ww -z " + path + " 2>&1"), "");
  const std::string page = ShellOutput("groff -man -Tascii -P-cbou -rLL=200n " + path);
  const std::vector<std::string> words = Words(absl::StrReplaceAll(page, {{",", " "}, {"=", " "}}));
  const std::set<std::string> told(words.begin(), words.end());
  for (const std::string& command : Commands()) {
    EXPECT_THAT(page, HasSubstr("egosieve " + command));
    EXPECT_THAT(told, IsSupersetOf(FlagsInHelp(command))) << command;
  }
  EXPECT_THAT(page, HasSubstr("finished with some frames failed"));
}

}  // namespace
}  // namespace egosieve::tools
