// Runs the Python tests beside this file against the installed module; skips, saying so, what is
// absent.
#include <filesystem>
#include <string>

#include "gtest/gtest.h"
#include "tests/tools/embed/testing/installed_tree.h"

namespace egosieve::embed {
namespace {

class PythonTest : public testing::TestWithParam<const char*> {};

TEST_P(PythonTest, Passes) {
  if (IsInstrumented()) GTEST_SKIP() << "python3 cannot load libraries with a sanitizer";
  const std::string name = GetParam();
  const bool with_sklearn = name == "check_estimator_test" || name == "scikit_learn_test" ||
                            name == "classifier_test" || name == "covariance_test";
  const std::string needed = with_sklearn ? "sklearn" : "numpy";
  if (RunClean("/", "python3 -c 'import " + needed + "'").code != 0) {
    GTEST_SKIP() << "there is no python3 with " << needed;
  }
  const std::string script =
      std::filesystem::absolute("tests/tools/embed/python/" + name + ".py").string();
  const CommandOutcome outcome = RunClean(NewFolder(name), "python3 -B '" + script + "'",
                                          "PYTHONPATH='" + InstalledPythonFolder() + "'");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
}

INSTANTIATE_TEST_SUITE_P(All, PythonTest,
                         testing::Values("gaussian_process_test", "joint_posterior_test",
                                         "segmenter_test", "sparse_test", "iterative_test",
                                         "device_call_test", "far_inputs_test", "precision_test",
                                         "optimization_test", "estimator_test",
                                         "several_devices_test", "check_estimator_test",
                                         "scikit_learn_test", "classifier_test", "covariance_test"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace egosieve::embed
