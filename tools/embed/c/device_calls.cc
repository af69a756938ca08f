#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/c/model_handles.h"
#include "tools/embed/c/options.h"
#include "tools/embed/c/prediction.h"
#include "tools/embed/include/egosieve/device_call.h"

namespace egosieve::embed {
namespace {

absl::StatusOr<kernels::Contexts> ContextsOf(const char* const* devices, int64_t count) {
  constexpr int64_t kMostDevices = 1024;
  if (count < 1 || count > kMostDevices) {
    return absl::InvalidArgumentError(
        absl::StrFormat("device_count = %d; it must be 1 to %d", count, kMostDevices));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckPointer("devices", devices));
  kernels::Contexts contexts;
  for (int64_t i = 0; i < count; ++i) {
    absl::StatusOr<std::shared_ptr<kernels::Context>> context = ContextOf(devices[i]);
    if (!context.ok()) {
      return absl::Status(context.status().code(),
                          absl::StrFormat("devices[%d]: %s", i, context.status().message()));
    }
    contexts.push_back(*std::move(context));
  }
  return contexts;
}

absl::Status CheckOnDevice(const DevicePosterior& at) {
  if (at.devices > 1) {
    return absl::FailedPreconditionError(
        absl::StrFormat("a queue belongs to one device; this posterior lies on %d", at.devices));
  }
  if (!at.context->is_reference()) return absl::OkStatus();
  return absl::FailedPreconditionError("the device \"reference\" has no OpenCL context");
}

absl::Status Enqueue(const DevicePosterior& at, const egosieve_device_call* call, void** event) {
  egosieve_device_call given;
  egosieve_device_call_init(&given);
  EGOSIEVE_RETURN_IF_ERROR(ReadStruct("call", call, given));
  EGOSIEVE_RETURN_IF_ERROR(CheckOnDevice(at));
  if (given.probability.memory != nullptr) EGOSIEVE_RETURN_IF_ERROR(at.labels);
  constexpr int64_t kMostEvents = 1 << 20;
  if (given.wait_count < 0 || given.wait_count > kMostEvents) {
    return absl::InvalidArgumentError(
        absl::StrFormat("call.wait_count = %d; it must be 0 to 2^20", given.wait_count));
  }
  if (given.wait_count > 0) EGOSIEVE_RETURN_IF_ERROR(CheckPointer("call.wait", given.wait));
  std::vector<cl_event> wait;
  for (int64_t i = 0; i < given.wait_count; ++i) {
    wait.push_back(static_cast<cl_event>(given.wait[i]));
  }
  const auto output = [](const egosieve_device_array& array) {
    return kernels::DeviceOutput{static_cast<cl_mem>(array.memory), array.first};
  };
  kernels::DeviceOutputs outputs;
  outputs.mean = output(given.mean);
  outputs.variance = output(given.variance);
  outputs.probability = output(given.probability);
  outputs.clamped = output(given.clamped);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const cl_event done,
      at.in_float32().Enqueue({static_cast<cl_mem>(given.queries), given.query_count,
                               given.query_first, given.query_stride},
                              outputs,
                              {static_cast<cl_command_queue>(given.queue), wait.data(),
                               static_cast<uint32_t>(wait.size())}));
  if (event != nullptr) {
    *event = done;
  } else {
    clReleaseEvent(done);
  }
  return absl::OkStatus();
}

}  // namespace
extern "C" {

void egosieve_device_call_init(egosieve_device_call* call) {
  if (call == nullptr) return;
  *call = egosieve_device_call{};
  call->struct_size = sizeof *call;
}

egosieve_status egosieve_gp_posterior_on_devices(egosieve_gp* gp, const char* const* devices,
                                                 int64_t device_count,
                                                 egosieve_posterior** posterior) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("posterior", posterior));
    EGOSIEVE_ASSIGN_OR_RETURN(const auto contexts, ContextsOf(devices, device_count));
    EGOSIEVE_ASSIGN_OR_RETURN(DevicePosterior made, model.PosteriorOn(contexts));
    EGOSIEVE_ASSIGN_OR_RETURN(
        *posterior,
        AllPosteriors().Insert(std::make_shared<const DevicePosterior>(std::move(made))));
    return absl::OkStatus();
  });
}

egosieve_status egosieve_posterior_float32_error(egosieve_posterior* posterior, double* mean,
                                                 double* variance, double* deviation) {
  return WithPosterior(__func__, posterior, [&](const DevicePosterior& found) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const gp::Float32Error error,
                              found.posterior->Error(/*with_variance=*/true));
    if (mean != nullptr) *mean = error.mean;
    if (variance != nullptr) *variance = error.variance;
    if (deviation != nullptr) *deviation = error.deviation;
    return absl::OkStatus();
  });
}

egosieve_status egosieve_posterior_opencl(egosieve_posterior* posterior, void** opencl_context,
                                          void** opencl_device) {
  return WithPosterior(__func__, posterior, [&](const DevicePosterior& found) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckOnDevice(found));
    if (opencl_context != nullptr) *opencl_context = found.context->cl_context()();
    if (opencl_device != nullptr) *opencl_device = found.context->cl_device()();
    return absl::OkStatus();
  });
}

egosieve_status egosieve_posterior_enqueue(egosieve_posterior* posterior,
                                           const egosieve_device_call* call, void** event) {
  return WithPosterior(__func__, posterior,
                       [&](const DevicePosterior& found) { return Enqueue(found, call, event); });
}

}  // extern "C"

}  // namespace egosieve::embed
