#include "tools/cli/command_line.h"

#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <sstream>

#include "gmock/gmock.h"
#include "tests/tools/testing/outcome.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/research_flag.h"

namespace egosieve::tools {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class FakeCommand : public Command {
 public:
  explicit FakeCommand(absl::StatusOr<ExitCode> result) : result_(std::move(result)) {}
  std::string name() const override { return "sift"; }
  std::string summary() const override { return "Sifts."; }
  std::string example() const override { return "egosieve sift --stride=3"; }
  void AddFlags(CLI::App& app) override {
    app.add_option("--stride", stride_, "Pixels")->check(CLI::Range(1, 100));
    app.add_option("--seed", seed_, "Number");
    app.add_option("--name", name_, "Empty unless given");
    app.add_option("--must", must_, "Needed")->required(required);
    app.add_option("--two_words", words_, "Number");
    app.add_option("--research.weight", weight_, "Its weight")
        ->check(CLI::Range(0.0, 1.0))
        ->group(kResearchTable);
    AddSetFlag(app);
  }
  absl::StatusOr<ExitCode> Run() override {
    last_stride = stride_;
    last_words = words_;
    last_weight = weight_;
    return result_;
  }
  static inline int last_stride = 0, last_words = 0;
  static inline double last_weight = 0.0;
  static inline bool required = false;

 private:
  int stride_ = 5;
  int seed_ = 0, words_ = 0;
  double weight_ = 0.5;
  std::string name_, must_;
  absl::StatusOr<ExitCode> result_;
};

struct Outcome {
  int code;
  std::string out, err;
};

Outcome Invoke(std::vector<std::string> arguments,
               absl::StatusOr<ExitCode> result = ExitCode::kDone) {
  CommandLine line("egosieve", "Segments.", "1.2.3");
  line.Add(std::make_unique<FakeCommand>(std::move(result)));
  std::ostringstream out, err;
  const int code = line.Run(std::move(arguments), out, err);
  return {code, out.str(), err.str()};
}

TEST(CommandLine, AConfigThatIsAPipeIsNotWaitedFor) {
  const std::string pipe = testing::TempDir() + "/pipe.toml";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(Invoke({"sift", "--config=" + pipe}), Says(2, "no regular file"));
}

TEST(CommandLine, ResultsThatCannotBeWrittenAreAnError) {
  CommandLine line("egosieve", "Segments.", "1.2.3");
  std::ofstream full("/dev/full");
  std::ostringstream err;
  EXPECT_EQ(line.Run({"--help"}, full, err), 1);
  EXPECT_THAT(err.str(), HasSubstr("stdout"));
}

TEST(CommandLine, RunsTheCommandWithItsFlags) {
  EXPECT_EQ(Invoke({"sift", "--stride=7"}).code, 0);
  EXPECT_EQ(FakeCommand::last_stride, 7);
  EXPECT_EQ(Invoke({"sift"}, ExitCode::kFramesFailed).code, 4);
  EXPECT_EQ(FakeCommand::last_stride, 5);
}

TEST(CommandLine, HelpListsCommandsAndEndsWithTheExample) {
  const Outcome all = Invoke({"--help"});
  EXPECT_EQ(all.code, 0);
  EXPECT_THAT(all.out, HasSubstr("sift  Sifts."));
  const Outcome one = Invoke({"sift", "--help"});
  EXPECT_EQ(one.code, 0);
  EXPECT_THAT(one.out, HasSubstr("--stride"));
  EXPECT_THAT(one.out, EndsWith("Example:\n  egosieve sift --stride=3\n"));
  EXPECT_EQ(Invoke({"--version"}).out, "egosieve 1.2.3\n");
}

TEST(CommandLine, VersionEndsWithTheBuild) {
  CommandLine line("egosieve", "", "1.2.3", "commit 1a2b3c");
  std::ostringstream out, err;
  EXPECT_EQ(line.Run({"--version"}, out, err), 0);
  EXPECT_EQ(out.str(), "egosieve 1.2.3, commit 1a2b3c\n");
}

TEST(CommandLine, UsageErrorsNameTheFlagAndPointToHelp) {
  EXPECT_EQ(Invoke({}).code, 2);
  EXPECT_THAT(Invoke({}).err, HasSubstr("Usage: egosieve COMMAND"));

  const Outcome flag = Invoke({"sift", "--strid=3"});
  EXPECT_EQ(flag.code, 2);
  EXPECT_EQ(flag.err, "egosieve: unknown flag --strid; see egosieve sift --help\n");

  const Outcome range = Invoke({"sift", "--stride=0"});
  EXPECT_EQ(range.code, 2);
  EXPECT_THAT(range.err, StartsWith("egosieve: --stride: "));
  EXPECT_THAT(range.err, EndsWith("; see egosieve sift --help\n"));

  const Outcome word = Invoke({"sift", "--seed=many"});
  EXPECT_EQ(word.code, 2);
  EXPECT_EQ(word.err, "egosieve: Could not convert: --seed = many; see egosieve sift --help\n");

  EXPECT_THAT(Invoke({"sift", "--name=a", "--name=b"}), Says(2, "--name: At Most 1 required"));

  EXPECT_THAT(Invoke({"sift", "a.mp4"}), Says(2, "unexpected argument 'a.mp4'"));

  // The flag that was misspelt is the one that is required.
  FakeCommand::required = true;
  EXPECT_EQ(Invoke({"sift", "--mist=3"}).err,
            "egosieve: unknown flag --mist; see egosieve sift --help\n");
  EXPECT_EQ(Invoke({"sift", "a.mp4"}).err,
            "egosieve: --must is required; see egosieve sift --help\n");
  FakeCommand::required = false;

  const Outcome command = Invoke({"shift"});
  EXPECT_EQ(command.code, 2);
  EXPECT_EQ(command.err, "egosieve: unknown command shift; see egosieve --help\n");
}

TEST(CommandLine, HyphensAreUnderscores) {
  EXPECT_EQ(Invoke({"sift", "--two-words=3"}).code, 0);
  EXPECT_EQ(FakeCommand::last_words, 3);
  EXPECT_EQ(Invoke({"sift", "--name=a-b", "--print-config"}).code, 0);
  EXPECT_THAT(Invoke({"sift", "--name=a-b", "--print-config"}).out, HasSubstr("name=\"a-b\""));
}

TEST(CommandLine, ResearchSettingsAreSetByNameOrFile) {
  const std::string path = testing::TempDir() + "/research.toml";
  std::ofstream(path) << "two-words = 2\n[research]\nweight = 0.25\n";
  EXPECT_EQ(Invoke({"sift", "--config=" + path}).code, 0);
  EXPECT_EQ(FakeCommand::last_words, 2);
  EXPECT_EQ(FakeCommand::last_weight, 0.25);
  EXPECT_EQ(Invoke({"sift", "--config=" + path, "--set", "weight=0.75"}).code, 0);
  EXPECT_EQ(FakeCommand::last_weight, 0.75);
  EXPECT_THAT(Invoke({"sift", "--weight=1"}), Says(2, "unknown flag --weight"));
  EXPECT_EQ(Invoke({"sift", "--set=weight=7"}).err.rfind("egosieve: --set weight: ", 0), 0u);
  EXPECT_EQ(Invoke({"sift", "--set=weigt=1"}).err,
            "egosieve: unknown flag --set weigt; see egosieve sift --help\n");
  EXPECT_EQ(
      Invoke({"sift", "--set=weight"}).err,
      "egosieve: --set weight has no value; give one as --set weight=VALUE; see egosieve sift "
      "--help\n");
  std::ofstream(path) << "weight = 0.25\n";
  EXPECT_THAT(
      Invoke({"sift", "--config=" + path}),
      Says(2, "'weight' in the file of --config is a research setting: put it under [research]"));

  EXPECT_THAT(Invoke({"sift", "--help"}).out, Not(HasSubstr("Its weight")));
  EXPECT_THAT(Invoke({"sift", "--print_config"}).out,
              EndsWith("[research]\n\n# Its weight\n# weight=0.5\n"));
  EXPECT_THAT(Invoke({"sift", "--set=weight=1", "--print_config"}).out,
              EndsWith("[research]\n\n# Its weight\nweight=1\n"));
}

TEST(DefaultFolder, GoesByTheInputsName) {
  EXPECT_EQ(DefaultFolder("/videos/drive.mp4"), "out/drive");
  EXPECT_EQ(DefaultFolder("clips/one/"), "out/one");
  EXPECT_EQ(DefaultFolder("clips/one/*.png"), "out/one");
  EXPECT_EQ(DefaultFolder("rtsp://camera:554/front"), "out/front");
}

TEST(CommandLine, AFlagIsNoFlagsValue) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"sift", "--name="},
                                                    {"sift", "--name"},
                                                    {"sift", "--name=", "--stride=3"},
                                                    {"sift", "--name=", "a.mp4"},
                                                    {"sift", "--name", "--stride=3"},
                                                    {"sift", "--stride", "3", "--name"}}) {
    FakeCommand::last_stride = 0;
    const Outcome outcome = Invoke(arguments);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.err,
              "egosieve: --name has no value; give one as --name=VALUE; see egosieve sift "
              "--help\n");
    EXPECT_EQ(FakeCommand::last_stride, 0);
  }
  EXPECT_EQ(Invoke({"sift", "--name=--stride=3"}).err, "");
  EXPECT_EQ(FakeCommand::last_stride, 5);
  EXPECT_EQ(Invoke({"sift", "--name", "a", "--stride", "3"}).err, "");
  EXPECT_EQ(FakeCommand::last_stride, 3);
}

TEST(CommandLine, AStatusBecomesOneLineAndItsExitCode) {
  const auto code = [](absl::Status status) { return Invoke({"sift"}, std::move(status)).code; };
  EXPECT_EQ(code(absl::InvalidArgumentError("x")), 2);
  EXPECT_EQ(code(absl::AlreadyExistsError("x")), 2);
  EXPECT_EQ(code(absl::NotFoundError("x")), 3);
  EXPECT_EQ(code(absl::DataLossError("x")), 3);
  EXPECT_EQ(code(absl::CancelledError("x")), 130);
  EXPECT_EQ(code(absl::ResourceExhaustedError("x")), 1);
  EXPECT_EQ(Invoke({"sift"}, absl::NotFoundError("no a.mp4;\ngive a file")).err,
            "egosieve: no a.mp4; give a file\n");
}

TEST(CommandLine, ConfigFilesHoldFlagsAndUnknownKeysAreErrors) {
  const std::string path = testing::TempDir() + "/sift.toml";
  FakeCommand::required = true;
  EXPECT_EQ(Invoke({"sift"}).err, "egosieve: --must is required; see egosieve sift --help\n");
  const Outcome printed = Invoke({"sift", "--stride=9", "--print_config"});
  FakeCommand::required = false;
  EXPECT_EQ(printed.code, 0);
  EXPECT_THAT(printed.out, testing::Not(HasSubstr("name")));
  std::ofstream(path) << printed.out;
  EXPECT_EQ(Invoke({"sift", "--config", path}).code, 0) << printed.out;
  EXPECT_EQ(FakeCommand::last_stride, 9);
  EXPECT_EQ(Invoke({"sift", "--stride=4", "--config", path}).code, 0);
  EXPECT_EQ(FakeCommand::last_stride, 4);

  std::ofstream(path) << "stride = 3\nstrode = 4\n";
  EXPECT_THAT(Invoke({"sift", "--config", path}), Says(2, "unknown key 'strode'"));

  std::ofstream(path) << "stride = 3 # how far\nname = 'a # b'\n";
  EXPECT_EQ(Invoke({"sift", "--config", path}).code, 0);
  EXPECT_EQ(FakeCommand::last_stride, 3);
  std::ofstream(path) << "stride = 3\nname = a b\n";
  const Outcome wrong = Invoke({"sift", "--config", path});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, StartsWith("egosieve: the file of --config is no TOML: line 2"));
  EXPECT_EQ(std::count(wrong.err.begin(), wrong.err.end(), '\n'), 1);

  const Outcome missing = Invoke({"sift", "--config=/nowhere/sift.toml"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.err, StartsWith("egosieve: /nowhere/sift.toml was not readable"));
}

}  // namespace
}  // namespace egosieve::tools
