#include "tests/kernels/failing_calls.h"

#include <CL/cl.h>
#include <dlfcn.h>

#include <mutex>
#include <tuple>
#include <type_traits>
#include <utility>

namespace egosieve::kernels {
namespace {

std::mutex mutex;
std::string armed;
int countdown = 0;
cl_int failure = 0;
bool failed = false;
int64_t host_bytes = 0;
int64_t scratch_bytes = 0;

void CountBytes(bool of_host, size_t bytes) {
  const std::lock_guard<std::mutex> lock(mutex);
  (of_host ? host_bytes : scratch_bytes) += static_cast<int64_t>(bytes);
}

// Whether this call is the one that fails, and then its code.
bool Fails(const char* function, cl_int* code) {
  const std::lock_guard<std::mutex> lock(mutex);
  if (armed != function || failed || countdown-- > 0) return false;
  failed = true;
  *code = failure;
  return true;
}

// Fails, or passes the call to the driver. Where a call gives no code, the last argument takes it.
template <typename Function, typename... Arguments>
auto Pass(const char* name, Arguments... arguments) {
  using Result = std::invoke_result_t<Function*, Arguments...>;
  cl_int code;
  if (!Fails(name, &code)) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name))(arguments...);
  }
  if constexpr (std::is_same_v<Result, cl_int>) {
    return code;
  } else {
    cl_int* error = std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...));
    if (error != nullptr) *error = code;
    return Result(nullptr);
  }
}

}  // namespace

std::vector<std::string> FailingCalls() {
  return {"clCreateKernel",          "clCreateCommandQueue",   "clCreateBuffer",
          "clSetKernelArg",          "clEnqueueNDRangeKernel", "clEnqueueMapBuffer",
          "clEnqueueUnmapMemObject", "clEnqueueReadBuffer",    "clFinish"};
}

void FailCall(const std::string& function, int nth, int code) {
  const std::lock_guard<std::mutex> lock(mutex);
  armed = function;
  countdown = nth;
  failure = code;
  failed = false;
}

int64_t TakeHostBytes() {
  const std::lock_guard<std::mutex> lock(mutex);
  return std::exchange(host_bytes, 0);
}

int64_t TakeScratchBytes() {
  const std::lock_guard<std::mutex> lock(mutex);
  return std::exchange(scratch_bytes, 0);
}

bool CallHasFailed() {
  const std::lock_guard<std::mutex> lock(mutex);
  armed.clear();
  return failed;
}

}  // namespace egosieve::kernels

using egosieve::kernels::CountBytes;
using egosieve::kernels::Pass;

extern "C" {

cl_kernel clCreateKernel(cl_program program, const char* name, cl_int* error) {
  return Pass<decltype(clCreateKernel)>(__func__, program, name, error);
}

cl_command_queue clCreateCommandQueue(cl_context context, cl_device_id device,
                                      cl_command_queue_properties properties, cl_int* error) {
  return Pass<decltype(clCreateCommandQueue)>(__func__, context, device, properties, error);
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host,
                      cl_int* error) {
  const cl_mem buffer = Pass<decltype(clCreateBuffer)>(__func__, context, flags, size, host, error);
  if (buffer != nullptr) CountBytes(host != nullptr, size);
  return buffer;
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset,
                            size_t size, const void* source, cl_uint count, const cl_event* wait,
                            cl_event* event) {
  const cl_int code = Pass<decltype(clEnqueueWriteBuffer)>(
      __func__, queue, buffer, blocking, offset, size, source, count, wait, event);
  if (code == CL_SUCCESS) CountBytes(/*of_host=*/true, size);
  return code;
}

cl_int clSetKernelArg(cl_kernel kernel, cl_uint index, size_t size, const void* value) {
  return Pass<decltype(clSetKernelArg)>(__func__, kernel, index, size, value);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                              const size_t* offset, const size_t* global, const size_t* local,
                              cl_uint count, const cl_event* wait, cl_event* event) {
  return Pass<decltype(clEnqueueNDRangeKernel)>(__func__, queue, kernel, dimensions, offset, global,
                                                local, count, wait, event);
}

void* clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                         cl_map_flags flags, size_t offset, size_t size, cl_uint count,
                         const cl_event* wait, cl_event* event, cl_int* error) {
  return Pass<decltype(clEnqueueMapBuffer)>(__func__, queue, buffer, blocking, flags, offset, size,
                                            count, wait, event, error);
}

cl_int clEnqueueUnmapMemObject(cl_command_queue queue, cl_mem memory, void* mapped, cl_uint count,
                               const cl_event* wait, cl_event* event) {
  return Pass<decltype(clEnqueueUnmapMemObject)>(__func__, queue, memory, mapped, count, wait,
                                                 event);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset,
                           size_t size, void* target, cl_uint count, const cl_event* wait,
                           cl_event* event) {
  return Pass<decltype(clEnqueueReadBuffer)>(__func__, queue, buffer, blocking, offset, size,
                                             target, count, wait, event);
}

cl_int clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void* pattern,
                           size_t pattern_size, size_t offset, size_t size, cl_uint count,
                           const cl_event* wait, cl_event* event) {
  return Pass<decltype(clEnqueueFillBuffer)>(__func__, queue, buffer, pattern, pattern_size, offset,
                                             size, count, wait, event);
}

cl_int clSetEventCallback(cl_event event, cl_int type,
                          void(CL_CALLBACK* notify)(cl_event, cl_int, void*), void* data) {
  return Pass<decltype(clSetEventCallback)>(__func__, event, type, notify, data);
}

cl_int clFinish(cl_command_queue queue) { return Pass<decltype(clFinish)>(__func__, queue); }

}  // extern "C"
