// PoCL compiles a kernel for each shape of a launch and keeps every one on disk: what differs from
// frame to frame, the numbers of features and of the model's points, must not be part of the shape.
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

namespace fs = std::filesystem;

// The compiled variants of `kernel` below PoCL's cache folder.
std::set<std::string> Variants(const std::string& folder, const std::string& kernel) {
  std::set<std::string> variants;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".so" &&
        entry.path().string().find("/" + kernel + "/") != std::string::npos) {
      variants.insert(entry.path().string());
    }
  }
  return variants;
}

class KernelVariants : public testing::Test {
 protected:
  // PoCL reads the variable once in a process.
  static void SetUpTestSuite() {
    fs::create_directories(Folder());
    setenv("POCL_CACHE_DIR", Folder().c_str(), 1);
  }
  static std::string Folder() { return testing::TempDir() + "/pocl"; }

  void SetUp() override {
    ContextOptions options;
    context_ = Value(OpenContext(options));
  }

  std::shared_ptr<Context> context_;
};

TEST_F(KernelVariants, TheSizeOfTheModelMakesNoNewOnes) {
  constexpr int64_t kDimension = 6;
  const CovarianceParameters parameters = {CovarianceFunction::kArcsine,
                                           std::vector<double>(kDimension + 1, 1.0), 1.0};
  for (const int64_t size : {1, 2, 3, 5, 7, 16, 17, 31, 64, 65, 200, 301}) {
    const std::vector<double> x(size * kDimension, 0.5);
    std::vector<double> out(size * size);
    ASSERT_TRUE(CovarianceMatrix(*context_, parameters, {x.data(), size, kDimension}, 0.01,
                                 Triangle::kLower, {out.data(), size, size})
                    .ok());
  }
  const std::set<std::string> variants = Variants(Folder(), "covariance_block");
  if (variants.empty()) GTEST_SKIP() << "this device keeps nothing in POCL_CACHE_DIR";
  EXPECT_EQ(variants.size(), 1u);
}

}  // namespace
}  // namespace egosieve::kernels
