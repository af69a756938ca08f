// PoCL compiles a kernel for each shape of a launch and keeps every one on disk: what differs from
// frame to frame, the number of features, must not be part of the shape.
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/descriptor_field.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"

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

TEST(KernelVariants, TheNumberOfPointsMakesNoNewOnes) {
  const std::string folder = testing::TempDir() + "/pocl";
  fs::create_directories(folder);
  setenv("POCL_CACHE_DIR", folder.c_str(), 1);
  ContextOptions options;
  options.program_cache = false;
  const auto context = OpenContext(options);
  ASSERT_TRUE(context.ok()) << context.status();
  const std::vector<uint8_t> pixels(32 * 24, 100);
  const ImageView image = {pixels.data(), 32, 24, 1, 32};
  constexpr int kMost = 24;
  for (int64_t count = 1; count <= kMost; ++count) {
    const std::vector<double> points(2 * count, 5.0);
    std::vector<float> out(kDescriptorDimension * count);
    ASSERT_TRUE(DescriptorsAt(**context, image, {points.data(), count, 2}, {},
                              {out.data(), count, kDescriptorDimension})
                    .ok());
  }
  const std::set<std::string> variants = Variants(folder, "descriptors_at");
  if (variants.empty()) GTEST_SKIP() << "this device keeps nothing in POCL_CACHE_DIR";
  EXPECT_EQ(variants.size(), 1u);
}

}  // namespace
}  // namespace egosieve::kernels
