// Where the driver could not build a program, neither that nor another of the context is released:
// PoCL keeps its locks after some failures, and clReleaseProgram then waits for ever. So does the
// next clBuildProgram where memory was lacking.
#include <CL/cl.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>

#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"

namespace {

std::atomic<bool> fails = false;
std::atomic<bool> has_failed = false;
std::atomic<int> releases = 0;  // since then
std::atomic<int> calls = 0;     // of clBuildProgram

template <typename Function>
Function* Driver(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

cl_int clBuildProgram(cl_program program, cl_uint device_count, const cl_device_id* devices,
                      const char* options, void(CL_CALLBACK* notify)(cl_program, void*),
                      void* data) {
  ++calls;
  if (fails.exchange(false)) {
    has_failed = true;
    return CL_OUT_OF_HOST_MEMORY;
  }
  return Driver<decltype(clBuildProgram)>(__func__)(program, device_count, devices, options, notify,
                                                    data);
}

cl_int clReleaseProgram(cl_program program) {
  if (has_failed) ++releases;
  return Driver<decltype(clReleaseProgram)>(__func__)(program);
}

}  // extern "C"

namespace egosieve::kernels {
namespace {

TEST(FailedBuild, IsNotReleased) {
  ContextOptions options;
  auto context = OpenContext(options);
  ASSERT_TRUE(context.ok()) << context.status();
  if ((*context)->is_reference()) GTEST_SKIP() << "the reference compiles nothing";
  const auto builds = [&](const std::string& more) {
    const std::string flags = "-cl-std=CL1.2 -DVEC=1 -DCHAINS=1" + more;
    return (*context)->Kernel("roofline.cl", flags, "multiply_add").ok();
  };
  ASSERT_TRUE(builds(""));
  fails = true;
  EXPECT_FALSE(builds(" -DOTHER"));
  EXPECT_TRUE(has_failed);
  (*context).reset();
  EXPECT_EQ(releases, 0);

  // PoCL's compiler would wait for its own lock: this context builds nothing more, another does.
  context = OpenContext(options);
  ASSERT_TRUE(context.ok()) << context.status();
  if ((*context)->info().platform.find("Portable Computing Language") == std::string::npos) return;
  has_failed = false;
  ASSERT_TRUE(builds(""));
  fails = true;
  calls = 0;
  EXPECT_FALSE(builds(" -DOTHER"));
  EXPECT_FALSE(builds(" -DOTHER"));
  EXPECT_FALSE(builds(""));
  EXPECT_EQ(calls, 1);
  context = OpenContext(options);
  EXPECT_TRUE(context.ok() && builds(" -DOTHER"));
}

}  // namespace
}  // namespace egosieve::kernels
