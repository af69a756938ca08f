#include <memory>
#include <string>
#include <vector>

#include "kernels/ops/covariance_matrix.h"
#include "kernels/runtime/opencl_context.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/include/egosieve/device_call.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kMostDevices = 1024;
constexpr int64_t kMostEvents = 1 << 20;

void CheckOnDevice(const DevicePosterior& at) {
  RequireState(at.devices == 1, "a queue belongs to one device; this posterior lies on %d",
               at.devices);
  RequireState(!at.context->is_reference(), "the device \"reference\" has no OpenCL context");
}

std::vector<cl_event> EventsOf(const std::string& name, void* const* wait, int64_t count) {
  Require(count >= 0 && count <= kMostEvents, "%s_count = %d; it must be 0 to 2^20", name, count);
  if (count > 0) RequirePointer(name.c_str(), wait);
  std::vector<cl_event> events;
  for (int64_t i = 0; i < count; ++i) events.push_back(static_cast<cl_event>(wait[i]));
  return events;
}

kernels::DeviceCall CallOn(void* queue, const std::vector<cl_event>& wait) {
  return {static_cast<cl_command_queue>(queue), wait.data(), static_cast<uint32_t>(wait.size())};
}

// The event is the caller's, or released if it is not wanted.
void GiveEvent(cl_event done, void** event) {
  if (event != nullptr) {
    *event = done;
  } else {
    clReleaseEvent(done);
  }
}

cl_event Enqueue(const DevicePosterior& at, const egosieve_device_call& call) {
  CheckOnDevice(at);
  if (call.probability.memory != nullptr) Check(at.labels);
  const std::vector<cl_event> wait = EventsOf("call.wait", call.wait, call.wait_count);
  const auto output = [](const egosieve_device_array& array) {
    return kernels::DeviceOutput{static_cast<cl_mem>(array.memory), array.first};
  };
  kernels::DeviceOutputs outputs;
  outputs.mean = output(call.mean);
  outputs.variance = output(call.variance);
  outputs.probability = output(call.probability);
  outputs.clamped = output(call.clamped);
  return Take(at.in_float32().Enqueue(
      {static_cast<cl_mem>(call.queries), call.query_count, call.query_first, call.query_stride},
      outputs, CallOn(call.queue, wait)));
}

}  // namespace

extern "C" {

void egosieve_device_call_init(egosieve_device_call* call) { Initialise(call); }

egosieve_status egosieve_gp_posterior_on_devices(egosieve_gp* gp, const char* const* devices,
                                                 int64_t device_count,
                                                 egosieve_posterior** posterior) {
  return NewFrom(__func__, gp, posterior, [&](LearningModel& model) {
    Require(device_count >= 1 && device_count <= kMostDevices,
            "device_count = %d; it must be 1 to %d", device_count, kMostDevices);
    RequirePointer("devices", devices);
    kernels::Contexts contexts;
    for (int64_t i = 0; i < device_count; ++i) {
      auto context = ContextOf(devices[i]);
      Check(Named(absl::StrFormat("devices[%d]", i), context.status()));
      contexts.push_back(*std::move(context));
    }
    return std::make_shared<const DevicePosterior>(model.PosteriorOn(contexts));
  });
}

egosieve_status egosieve_posterior_opencl(egosieve_posterior* posterior, void** opencl_context,
                                          void** opencl_device) {
  return With(__func__, posterior, [&](const DevicePosterior& found) {
    CheckOnDevice(found);
    if (opencl_context != nullptr) *opencl_context = found.context->cl_context()();
    if (opencl_device != nullptr) *opencl_device = found.context->cl_device()();
  });
}

egosieve_status egosieve_posterior_enqueue(egosieve_posterior* posterior,
                                           const egosieve_device_call* call, void** event) {
  return With(__func__, posterior, [&](const DevicePosterior& found) {
    GiveEvent(Enqueue(found, Read("call", call, egosieve_device_call_init)), event);
  });
}

egosieve_status egosieve_gp_enqueue_covariances(egosieve_gp* gp, const egosieve_device_matrix* x,
                                                const egosieve_device_matrix* z,
                                                const egosieve_device_matrix* k, void* queue,
                                                void* const* wait, int64_t wait_count,
                                                void** event) {
  return With(__func__, gp, [&](LearningModel& model) {
    RequirePointer("x", x);
    RequirePointer("k", k);
    const auto matrix = [](const egosieve_device_matrix& m) {
      return kernels::BufferMatrix{static_cast<cl_mem>(m.memory), m.rows, m.first, m.stride};
    };
    const std::vector<cl_event> events = EventsOf("wait", wait, wait_count);
    GiveEvent(Take(kernels::EnqueueCrossCovariance(
                  model.context(), model.hyperparameters().covariance, matrix(*x),
                  matrix(z == nullptr ? *x : *z), matrix(*k), CallOn(queue, events))),
              event);
  });
}

}  // extern "C"

}  // namespace egosieve::embed
