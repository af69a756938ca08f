// Converts the OpenCL bindings' exceptions to statuses; they are converted nowhere else.
#pragma once

#include <CL/opencl.hpp>
#include <new>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace egosieve::kernels {

// "CL_OUT_OF_RESOURCES" and so on; the number of a code that is not standard.
std::string OpenClErrorName(cl_int code);

// States the failed action (`doing`), the call and the code. ResourceExhausted for lack of memory,
// Unavailable for a lost device, Internal for other errors.
absl::Status OpenClStatus(std::string_view doing, const cl::Error& error);
// The same with the log of the compiler.
absl::Status OpenClBuildStatus(std::string_view doing, const cl::BuildError& error);

// Runs `body`; an OpenCL exception or a lack of host memory becomes a status.
template <typename Body>
absl::Status CatchOpenClErrors(std::string_view doing, Body&& body) {
  try {
    std::forward<Body>(body)();
    return absl::OkStatus();
  } catch (const cl::BuildError& error) {
    return OpenClBuildStatus(doing, error);
  } catch (const cl::Error& error) {
    return OpenClStatus(doing, error);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(std::string(doing) + ": out of host memory");
  }
}

}  // namespace egosieve::kernels
