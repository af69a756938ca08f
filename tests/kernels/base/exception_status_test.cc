#include "kernels/base/exception_status.h"

#include <new>
#include <stdexcept>
#include <system_error>

#include "absl/status/statusor.h"
#include "gmock/gmock.h"

namespace egosieve::kernels {
namespace {

template <typename Exception>
absl::Status StatusOf(const Exception& exception) {
  return CatchExceptions([&]() -> absl::Status { throw exception; });
}

TEST(ExceptionStatus, TellsWhatTheMachineLacks) {
  EXPECT_EQ(StatusOf(std::bad_alloc()).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(StatusOf(std::length_error("vector")).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(StatusOf(std::runtime_error("(-4:Insufficient memory) Failed to allocate")).code(),
            absl::StatusCode::kResourceExhausted);
  const absl::Status refused =
      StatusOf(std::system_error(EAGAIN, std::generic_category(), "thread"));
  EXPECT_EQ(refused.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(refused.message(), testing::HasSubstr("--threads=1"));
  EXPECT_EQ(StatusOf(std::runtime_error("pthread_create has failed")).code(),
            absl::StatusCode::kUnavailable);
}

TEST(ExceptionStatus, AnythingElseIsInternal) {
  EXPECT_EQ(StatusOf(std::runtime_error("odd")).code(), absl::StatusCode::kInternal);
  EXPECT_EQ(StatusOf(7).code(), absl::StatusCode::kInternal);
}

TEST(ExceptionStatus, WithoutAnExceptionTheBodysResultComesBack) {
  EXPECT_TRUE(CatchExceptions([] { return absl::OkStatus(); }).ok());
  EXPECT_EQ(*CatchExceptions([]() -> absl::StatusOr<int> { return 3; }), 3);
}

}  // namespace
}  // namespace egosieve::kernels
