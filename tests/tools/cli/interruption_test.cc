#include "tools/cli/interruption.h"

#include <unistd.h>

#include <csignal>

#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

TEST(Interruption, TheFirstIsARequestAndTheSecondEndsTheProcess) {
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          CatchInterruptions();
          raise(signal);
          if (!InterruptionRequested()) _exit(1);
          raise(signal);
          _exit(2);
        },
        testing::KilledBySignal(signal), "");
  }
}

TEST(Interruption, OneOfEachKindIsARequest) {
  EXPECT_EXIT(
      {
        CatchInterruptions();
        raise(SIGINT);
        raise(SIGTERM);
        _exit(InterruptionRequested() ? 7 : 1);
      },
      testing::ExitedWithCode(7), "");
}

TEST(Interruption, ThoseHeldBackAreCaughtLater) {
  EXPECT_EXIT(
      {
        HoldInterruptions();
        raise(SIGINT);
        if (InterruptionRequested()) _exit(1);
        CatchInterruptions();
        _exit(InterruptionRequested() ? 7 : 2);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace egosieve::tools
