// OpenCL calls that fail when a test wants them to. A program that links this library gets its
// calls of the entry points below through it; each passes to the driver's unless a failure is
// armed.
#ifndef EGOSIEVE_TESTS_KERNELS_FAILING_CALLS_H_
#define EGOSIEVE_TESTS_KERNELS_FAILING_CALLS_H_

#include <string>
#include <vector>

namespace egosieve::kernels {

// The entry points that can fail: those of the operations, in the order in which they call them.
std::vector<std::string> FailingCalls();

// The call number `nth` (from 0) of `function` from now on returns `code`, once, without reaching
// the driver.
void FailCall(const std::string& function, int nth, int code);

// Whether the armed failure has happened. Disarms it.
bool CallHasFailed();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_TESTS_KERNELS_FAILING_CALLS_H_
