#include "kernels/ops/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/reference/plane_sweep.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/opencl_context.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels {
namespace {

constexpr int kMostRadius = 3;  // rows of at most 8 pixels

// The kernel loads 8 pixels at a time, also at the picture's end.
constexpr size_t kReadBeyond = 8;

absl::Status CheckPicture(const char* name, const ImageView& picture, const ImageGrid& grid) {
  if (picture.data != nullptr && picture.width == grid.width && picture.height == grid.height &&
      picture.channels == 1 && picture.stride_bytes >= picture.width) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s has %d x %d pixels of %d channels, %d bytes a row%s; it must be grey, of the grid's "
      "%d x %d",
      name, picture.width, picture.height, picture.channels, picture.stride_bytes,
      picture.data == nullptr ? ", without data" : "", grid.width, grid.height));
}

absl::Status CheckSteps(const std::vector<SweepStep>& steps) {
  if (steps.empty()) return absl::InvalidArgumentError("steps are empty; there must be at least 1");
  for (size_t j = 0; j < steps.size(); ++j) {
    if (std::isfinite(steps[j].inverse_depth) && IsPositive(steps[j].scale)) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("steps[%d] has inverse_depth = %g, scale = %g; they must be finite, and "
                        "scale positive",
                        j, steps[j].inverse_depth, steps[j].scale));
  }
  return absl::OkStatus();
}

absl::Status Check(const PlaneSweepInputs& inputs) {
  const ImageGrid& grid = inputs.grid;
  EGOSIEVE_RETURN_IF_ERROR(grid.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPicture("first", inputs.first, grid));
  EGOSIEVE_RETURN_IF_ERROR(CheckPicture("second", inputs.second, grid));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite<double>("homography", {inputs.homography.data(), 3, 3}));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite<double>("epipole", {inputs.epipole.data(), 1, 3}));
  EGOSIEVE_RETURN_IF_ERROR(CheckSteps(inputs.steps));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("flow", inputs.flow, grid.size(), 2));
  return CheckOptions(
      {{"patch_radius", inputs.patch_radius,
        inputs.patch_radius >= 1 && inputs.patch_radius <= kMostRadius, "be from 1 to 3"}});
}

// The exponent of the largest entry of H and e. (SW1) has a free scale: divided by two to this
// power, H and e are within the range of float32.
int LargestExponent(const PlaneSweepInputs& inputs) {
  double largest = 0.0;
  for (const double value : inputs.homography) largest = std::max(largest, std::abs(value));
  for (const double value : inputs.epipole) largest = std::max(largest, std::abs(value));
  return largest > 0.0 ? std::ilogb(largest) : 0;
}

// Row after row without gaps.
std::vector<uint8_t> Packed(const ImageView& picture) {
  std::vector<uint8_t> pixels(static_cast<size_t>(picture.width) * picture.height + kReadBeyond);
  for (int y = 0; y < picture.height; ++y) {
    std::copy_n(picture.data + y * picture.stride_bytes, picture.width,
                pixels.begin() + static_cast<int64_t>(y) * picture.width);
  }
  return pixels;
}

absl::Status SweepOnDevice(Context& context, const PlaneSweepInputs& inputs,
                           MatrixView<float> out) {
  constexpr char kDoing[] = "sweeping planes";
  const ImageGrid& grid = inputs.grid;
  const int64_t side_by_side = SideBySide(context);
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  EGOSIEVE_ASSIGN_OR_RETURN(
      cl::Kernel kernel,
      workspace->Kernel("plane_sweep.cl",
                        absl::StrCat("-cl-std=CL1.2 -DVEC=1 -DRADIUS=", inputs.patch_radius),
                        side_by_side > 1 ? "plane_sweep_by_place" : "plane_sweep"));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const std::vector<uint8_t> first = Packed(inputs.first), second = Packed(inputs.second);
    std::vector<float> motion, steps;
    const int exponent = LargestExponent(inputs);
    const auto add = [&](double value) {
      motion.push_back(static_cast<float>(std::ldexp(value, -exponent)));
    };
    for (const double value : inputs.homography) add(value);
    for (const double value : inputs.epipole) add(value);
    for (const SweepStep& step : inputs.steps) {
      steps.push_back(step.inverse_depth);
      steps.push_back(step.scale);
    }
    const cl::Buffer first_buffer = InputBuffer(context, first);
    const cl::Buffer second_buffer = InputBuffer(context, second);
    const cl::Buffer motion_buffer = InputBuffer(context, motion);
    const cl::Buffer step_buffer = InputBuffer(context, steps);
    const cl::Buffer flow_buffer = InputBuffer(context, inputs.flow);
    OutputBuffer<float> result(context, out, Unwritten::kPadding);
    SetArguments(kernel, first_buffer, second_buffer, cl_int{grid.width}, cl_int{grid.height},
                 cl_int{grid.stride}, cl_int{grid.columns()}, motion_buffer, step_buffer,
                 static_cast<cl_int>(inputs.steps.size()), flow_buffer, cl_long{inputs.flow.stride},
                 result.buffer(), cl_long{out.stride});
    const cl::CommandQueue& queue = workspace->queue();
    const CommandsEnd end(queue);
    if (side_by_side > 1) {
      const int64_t items = (grid.columns() + side_by_side - 1) / side_by_side * side_by_side;
      queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items, grid.rows()),
                                 cl::NDRange(side_by_side, 1));
    } else {
      queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(grid.rows()), cl::NDRange(1));
    }
    result.Finish(queue);
  }));
  context.GiveBack(std::move(workspace));
  return absl::OkStatus();
}

}  // namespace

absl::Status PlaneSweep(Context& context, const PlaneSweepInputs& inputs, MatrixView<float> out) {
  EGOSIEVE_RETURN_IF_ERROR(Check(inputs));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, inputs.grid.size(), kSweepColumns));
  if (context.is_reference()) {
    reference::PlaneSweep(inputs, out);
    return absl::OkStatus();
  }
  return SweepOnDevice(context, inputs, out);
}

}  // namespace egosieve::kernels
