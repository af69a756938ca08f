// Contexts of the C interface: programs outlive the models, memory of the device does not.
#include "tools/embed/c/device_contexts.h"

#include <unistd.h>

#include <CL/opencl.hpp>
#include <memory>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/failing_calls.h"
#include "tests/testing/status.h"

namespace egosieve::embed {
namespace {

using kernels::Context;
using kernels::Workspace;

class DeviceContexts : public testing::Test {
 protected:
  void SetUp() override {
    const auto context = Value(ContextOf(nullptr));
    if (context->is_reference()) GTEST_SKIP() << "the reference has no OpenCL context";
    // Retained, so that no other has its address.
    opencl_context_ = context->cl_context();
    device_ = context->cl_device();
  }
  void TearDown() override { kernels::CallHasFailed(); }

  cl::Context opencl_context_;
  cl::Device device_;
};

TEST_F(DeviceContexts, ServeTheNextUserAfterTheLast) {
  // The user of SetUp has gone.
  for (int user = 0; user < 2; ++user) {
    const auto context = Value(ContextOf(""));
    EXPECT_EQ(context->cl_context()(), opencl_context_());
  }
  const auto first = Value(ContextOf(nullptr)), second = Value(ContextOf(nullptr));
  EXPECT_EQ(first, second);
}

TEST_F(DeviceContexts, FreeTheirMemoryWithTheLastUser) {
  cl::Buffer scratch;
  {
    const auto first = Value(ContextOf(nullptr));
    auto workspace = Value(first->Borrow("testing"));
    scratch = workspace->Scratch(Workspace::Memory::kTiles, 1 << 20);
    first->GiveBack(std::move(workspace));
    Value(ContextOf(nullptr));  // and let go at once
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
    const auto named = Value(ContextOn(own(), device_()));
    for (void* device : {static_cast<void*>(nullptr), static_cast<void*>(device_())}) {
      const auto same = Value(ContextOn(own(), device));
      EXPECT_EQ(same, named);
    }
    EXPECT_GT(own.getInfo<CL_CONTEXT_REFERENCE_COUNT>(), count);
    EXPECT_FALSE(ContextOn(nullptr, nullptr).ok());
  }
  EXPECT_EQ(own.getInfo<CL_CONTEXT_REFERENCE_COUNT>(), count);
  const auto again = Value(ContextOn(own(), nullptr));
  EXPECT_EQ(again->cl_context()(), own());
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
  const auto adopted = Value(ContextOn(own(), nullptr));
  ASSERT_TRUE(ContextOf("reference").ok());
  EXPECT_EXIT(
      {
        alarm(60);
        _exit(NotRefused(own));
      },
      testing::ExitedWithCode(0), "");
  EXPECT_TRUE(ContextOf(nullptr).ok());
}

}  // namespace
}  // namespace egosieve::embed
