// OpenCL calls that fail when a test wants them to, and the bytes that pass through them. A program
// that links this library gets its calls of the entry points below through it; each passes to the
// driver's unless a failure is armed.
#pragma once

#include <cstdint>
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

// Bytes of the host's memory that were handed to the device since the last call: by buffers made
// over or from it, and by writes.
int64_t TakeHostBytes();
// Bytes of buffers that were made without the host's memory since the last call.
int64_t TakeScratchBytes();

}  // namespace egosieve::kernels
