// A system without /sys, where PoCL aborts the process by itself. Outside Bazel's sandbox, in which
// nothing can be mounted over /sys.
#include <unistd.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "tests/tools/end_to_end/machine.h"
#include "tests/tools/testing/patch_drive.h"

namespace egosieve::tools {
namespace {

TEST_F(Machine, ASystemWithoutSys) {
  // A root in a chroot may mount, but not become the root of a namespace.
  const std::string hidden = absl::StrCat("unshare ", geteuid() == 0 ? "" : "--map-root-user",
                                          " --mount sh -c 'mount -t tmpfs none /sys && ");
  if (Shell(hidden + "true'").code != 0) GTEST_SKIP() << "cannot hide /sys";
  const bool has_pocl = Shell("grep -q pocl /etc/OpenCL/vendors/*.icd").code == 0;
  if (!has_pocl) GTEST_SKIP() << "PoCL is not installed";
  WritePatchDrive(root_, SmallPatchDrive(3));
  const std::string segment =
      absl::StrCat("exec \"$EGOSIEVE\" segment ", root_,
                   "/frames --budget=100 --progress=none --out=", root_, "/run");
  for (const std::string& command : {std::string("exec \"$EGOSIEVE\" devices"), segment}) {
    ExpectOneLine(Shell(hidden + command + "' > /dev/null"), "mount /sys");
  }
  EXPECT_EQ(Shell(hidden + segment + " --device=reference' > /dev/null").code, 0);
}

}  // namespace
}  // namespace egosieve::tools
