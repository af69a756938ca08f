// Contexts of the C interface: programs outlive the models, memory of the device does not.
#include "tools/embed/c/device_contexts.h"

#include <sys/wait.h>
#include <unistd.h>

#include <CL/opencl.hpp>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/failing_calls.h"

namespace egosieve::embed {
namespace {

using kernels::Context;
using kernels::Workspace;

class DeviceContexts : public testing::Test {
 protected:
  void SetUp() override {
    const auto context = ContextOf(nullptr);
    ASSERT_TRUE(context.ok()) << context.status();
    if ((*context)->is_reference()) GTEST_SKIP() << "the reference has no OpenCL context";
    // Retained, so that no other has its address.
    opencl_context_ = (*context)->cl_context();
    device_ = (*context)->cl_device();
  }
  void TearDown() override { kernels::CallHasFailed(); }

  cl::Context opencl_context_;
  cl::Device device_;
};

TEST_F(DeviceContexts, ServeTheNextUserAfterTheLast) {
  // The user of SetUp has gone.
  for (int user = 0; user < 2; ++user) {
    const auto context = ContextOf("");
    ASSERT_TRUE(context.ok()) << context.status();
    EXPECT_EQ((*context)->cl_context()(), opencl_context_());
  }
  const auto first = ContextOf(nullptr), second = ContextOf(nullptr);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first->get(), second->get());
}

TEST_F(DeviceContexts, FreeTheirMemoryWithTheLastUser) {
  cl::Buffer scratch;
  {
    const auto first = ContextOf(nullptr);
    ASSERT_TRUE(first.ok()) << first.status();
    auto workspace = (*first)->Borrow("testing");
    ASSERT_TRUE(workspace.ok()) << workspace.status();
    scratch = (*workspace)->Scratch(Workspace::Memory::kTiles, 1 << 20);
    (*first)->GiveBack(*std::move(workspace));
    {
      const auto second = ContextOf(nullptr);
      ASSERT_TRUE(second.ok()) << second.status();
    }
    EXPECT_EQ(scratch.getInfo<CL_MEM_REFERENCE_COUNT>(), 2u);
  }
  EXPECT_EQ(scratch.getInfo<CL_MEM_REFERENCE_COUNT>(), 1u);
}

TEST_F(DeviceContexts, AreOpenedAnewIfTheyGiveNoMoreQueues) {
  kernels::FailCall("clCreateCommandQueue", 0, CL_OUT_OF_RESOURCES);
  const auto context = ContextOf(nullptr);
  EXPECT_TRUE(kernels::CallHasFailed());
  ASSERT_TRUE(context.ok()) << context.status();
  EXPECT_NE((*context)->cl_context()(), opencl_context_());
  EXPECT_TRUE((*context)->Borrow("testing").ok());
}

TEST_F(DeviceContexts, OfTheCallerAreSharedAndReleased) {
  const cl::Context own(device_);
  const cl_uint count = own.getInfo<CL_CONTEXT_REFERENCE_COUNT>();
  {
    const auto named = ContextOn(own(), device_());
    ASSERT_TRUE(named.ok()) << named.status();
    for (void* device : {static_cast<void*>(nullptr), static_cast<void*>(device_())}) {
      const auto same = ContextOn(own(), device);
      ASSERT_TRUE(same.ok()) << same.status();
      EXPECT_EQ(same->get(), named->get());
    }
    EXPECT_GT(own.getInfo<CL_CONTEXT_REFERENCE_COUNT>(), count);
    EXPECT_FALSE(ContextOn(nullptr, nullptr).ok());
  }
  EXPECT_EQ(own.getInfo<CL_CONTEXT_REFERENCE_COUNT>(), count);
  const auto again = ContextOn(own(), nullptr);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->cl_context()(), own());
}

// Which of the things that must be refused are not; called in the child.
int NotRefused(const cl::Context& own) {
  const auto refused = [](const absl::StatusOr<std::shared_ptr<Context>>& context) {
    return absl::IsFailedPrecondition(context.status()) &&
           std::string(context.status().message()).find("spawn") != std::string::npos;
  };
  if (!refused(ContextOf(nullptr))) return 1;
  if (!refused(ContextOn(own(), nullptr))) return 2;
  return ContextOf("reference").ok() ? 0 : 3;
}

TEST_F(DeviceContexts, AreRefusedToAForkedChild) {
  const cl::Context own(device_);
  const auto adopted = ContextOn(own(), nullptr);
  ASSERT_TRUE(adopted.ok()) << adopted.status();
  ASSERT_TRUE(ContextOf("reference").ok());
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    _exit(NotRefused(own));
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_TRUE(ContextOf(nullptr).ok());
}

}  // namespace
}  // namespace egosieve::embed
