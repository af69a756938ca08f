#include "kernels/runtime/driver_check.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "gmock/gmock.h"

namespace egosieve::kernels {
namespace {

class DriverCheck : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    setenv("OCL_ICD_VENDORS", folder_.c_str(), 1);
  }

  void Install(const std::string& library) const {
    std::ofstream(folder_ + "/driver.icd") << library << "\n";
  }
  bool Says(const std::string& text) const {
    const std::string why = WhyNoDevice();
    EXPECT_THAT(why, testing::HasSubstr("\"reference\""));
    if (why.find(text) != std::string::npos) return true;
    ADD_FAILURE() << why;
    return false;
  }

  std::string folder_;
};

TEST_F(DriverCheck, NothingInstalledSaysWhatToInstall) {
  EXPECT_TRUE(Says("install an OpenCL driver"));
  setenv("OCL_ICD_VENDORS", "/nowhere", 1);
  EXPECT_TRUE(Says("install an OpenCL driver"));
}

TEST_F(DriverCheck, ADriverThatDoesNotLoadIsNamedWithTheReason) {
  Install("/nowhere/libdriver.so");
  EXPECT_TRUE(Says("driver.icd does not load (/nowhere/libdriver.so: cannot open"));
}

TEST_F(DriverCheck, ADriverWithoutDevicesIsNotToBeInstalled) {
  Install("libc.so.6");
  EXPECT_TRUE(Says("libc.so.6 is installed and gives no device"));
  setenv("POCL_CACHE_DIR", "/some/cache", 1);
  EXPECT_TRUE(Says("/some/cache"));
}

TEST_F(DriverCheck, PoclIsNotStartedWhereItWouldAbort) {
  EXPECT_TRUE(CheckDriversCanStart("/nowhere").ok()) << "no driver is installed";
  Install("libother.so.1");
  EXPECT_TRUE(CheckDriversCanStart("/nowhere").ok()) << "others need no list of processors";
  Install("libpocl.so.2");
  EXPECT_TRUE(CheckDriversCanStart(testing::TempDir()).ok());
  const absl::Status status = CheckDriversCanStart("/nowhere");
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(status.message(), testing::HasSubstr("libpocl.so.2"));
  EXPECT_THAT(status.message(), testing::HasSubstr("mount /sys"));
}

}  // namespace
}  // namespace egosieve::kernels
