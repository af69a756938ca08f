#include "tools/model/model_command.h"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "gmock/gmock.h"
#include "gp/io/model_file.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/run_command.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

gp::ModelFile TwoPoints() {
  gp::ModelFile file;
  file.model.hyperparameters.covariance.scales = {1.0, 2.0, 3.0};  // bias and two inputs
  file.model.hyperparameters.noise_stddev = 0.5;
  file.model.points.inputs = {0.25, -0.5, 0.75, 1.0};
  file.model.points.targets = {-1.0, 0.5};
  file.model.points.identities = {3, 8};
  file.model.points.insertion_times = {1, 4};
  file.model.points.next_identity = 9;
  return file;
}

TEST(ModelCommand, DescribesAFileAndTheNewestOfARun) {
  const std::string root = testing::TempDir() + "/model_command";
  std::filesystem::remove_all(root);
  std::filesystem::create_directories(root + "/model");
  ASSERT_TRUE(gp::WriteModelFile(root + "/model/000024.npz", gp::ModelFile(TwoPoints())).ok());
  gp::ModelFile newer = TwoPoints();
  newer.model.points.insertion_times = {1, 44};
  ASSERT_TRUE(gp::WriteModelFile(root + "/model/000049.npz", newer).ok());

  testing::internal::CaptureStdout();
  const int code =
      RunCommandForTest(MakeModelCommand(), {root, "--csv=" + root + "/points.csv"}).code;
  const std::string out = testing::internal::GetCapturedStdout();
  EXPECT_EQ(code, 0);
  EXPECT_THAT(out, HasSubstr("model/000049.npz"));
  EXPECT_THAT(out, HasSubstr("points       2: 1 dynamic, 1 static"));
  EXPECT_THAT(out, HasSubstr("born         in frames 1 to 44"));
  EXPECT_EQ(*ReadFile(root + "/points.csv"),
            "identity,birth_frame,label,x0,x1\n3,1,0,0.25,-0.5\n8,44,0.75,0.75,1\n");
}

TEST(ModelCommand, ReplacesAFileOnRequestAndNothingElse) {
  const std::string root = testing::TempDir() + "/model_command_csv";
  std::filesystem::remove_all(root);
  std::filesystem::create_directories(root);
  const std::string model = root + "/model.npz", csv = root + "/points.csv";
  ASSERT_TRUE(gp::WriteModelFile(model, TwoPoints()).ok());
  const auto run = [&](const std::string& path, bool overwrite) {
    std::vector<std::string> arguments = {model, "--csv=" + path};
    if (overwrite) arguments.push_back("--overwrite");
    testing::internal::CaptureStdout();
    const CommandOutcome outcome = RunCommandForTest(MakeModelCommand(), arguments);
    testing::internal::GetCapturedStdout();
    return outcome;
  };
  std::ofstream(csv) << "mine";
  const CommandOutcome refused = run(csv, false);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("add --overwrite"));
  EXPECT_EQ(*ReadFile(csv), "mine");
  EXPECT_EQ(run(csv, true).code, 0);
  EXPECT_THAT(*ReadFile(csv), HasSubstr("identity,"));

  // What no command of ours can have written stays, whatever is asked.
  std::ofstream(root + "/target") << "mine";
  std::filesystem::create_symlink(root + "/target", root + "/link");
  ASSERT_EQ(mkfifo((root + "/pipe").c_str(), 0600), 0);
  for (const std::string& path : {root + "/link", root + "/pipe", root, model}) {
    const auto before = std::filesystem::symlink_status(path).type();
    EXPECT_EQ(run(path, true).code, 2) << path;
    EXPECT_EQ(std::filesystem::symlink_status(path).type(), before) << path;
  }
  EXPECT_EQ(*ReadFile(root + "/target"), "mine");
  EXPECT_TRUE(gp::ReadModelFile(model).ok());
}

TEST(ModelCommand, SaysWhatIsWrong) {
  EXPECT_EQ(RunCommandForTest(MakeModelCommand(), {"/nowhere.npz"}).code, 3);
  const std::string root = testing::TempDir() + "/model_command_bad";
  std::filesystem::create_directories(root);
  EXPECT_THAT(RunCommandForTest(MakeModelCommand(), {root}).err, HasSubstr("no checkpoint"));
  std::ofstream(root + "/text.npz") << "not a model";
  const CommandOutcome text = RunCommandForTest(MakeModelCommand(), {root + "/text.npz"});
  EXPECT_EQ(text.code, 3);
  EXPECT_THAT(text.err, HasSubstr("text.npz"));
}

}  // namespace
}  // namespace egosieve::tools
