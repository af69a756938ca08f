#include "kernels/ops/opencl_image.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kernels/base/status_macros.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels::opencl {
namespace {

// Bands of grid rows, one per work-item, each with scratch for two rows of sums.
constexpr int kMaxBands = 64;

// Points per work-group. The number is fixed, because PoCL compiles a kernel anew for every
// work-group size, and if PoCL chose the size, it would differ for nearly every number of points.
constexpr int64_t kGroupPoints = 64;

// `count` rounded up to whole groups.
int64_t WholeGroups(int64_t count, int64_t group) { return (count + group - 1) / group * group; }

std::string BuildOptions(int channels) {
  return "-cl-std=CL1.2 -DVEC=1 -DCHANNELS=" + std::to_string(channels);
}

cl::Buffer ImageBuffer(const Context& context, const ImageView& image) {
  return InputBuffer(
      context, image.data,
      (image.height - 1) * image.stride_bytes + static_cast<size_t>(image.width) * image.channels);
}

// Pixel positions of the grid along one axis and their normalised coordinates.
struct Axis {
  std::vector<cl_int> pixels;
  std::vector<float> coordinates;
};

template <typename PixelOf>
Axis MakeAxis(int count, PixelOf pixel_of, double scale, double offset) {
  Axis axis;
  for (int i = 0; i < count; ++i) {
    axis.pixels.push_back(pixel_of(i));
    axis.coordinates.push_back(static_cast<float>(pixel_of(i) * scale + offset));
  }
  return axis;
}

cl_int NearestPixel(double coordinate, int size) {
  return std::clamp(static_cast<int>(std::floor(coordinate + 0.5)), 0, size - 1);
}

}  // namespace

absl::Status BoxMeansOnGrid(Context& context, const ImageView& image, const ImageGrid& grid,
                            int window_pixels, MatrixView<float> out) {
  constexpr char kDoing[] = "computing box means on a grid";
  const int64_t side_by_side = SideBySide(context);
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  EGOSIEVE_ASSIGN_OR_RETURN(
      cl::Kernel kernel,
      workspace->Kernel("image.cl", BuildOptions(image.channels),
                        side_by_side > 1 ? "box_means_on_grid_by_point" : "box_means_on_grid"));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const PixelNormalization map = NormalizationForImage(image.width, image.height);
    const Axis x = MakeAxis(
        grid.columns(), [&](int i) { return grid.x_pixels(i); }, map.scale, map.u_offset);
    const Axis y = MakeAxis(
        grid.rows(), [&](int i) { return grid.y_pixels(i); }, map.scale, map.v_offset);
    const cl::Buffer image_buffer = ImageBuffer(context, image);
    const cl::Buffer x_buffer = InputBuffer(context, x.pixels);
    const cl::Buffer y_buffer = InputBuffer(context, y.pixels);
    const cl::Buffer u_buffer = InputBuffer(context, x.coordinates);
    const cl::Buffer v_buffer = InputBuffer(context, y.coordinates);
    cl::Buffer scratch;
    OutputBuffer<float> result(context, out, Unwritten::kPadding);
    cl::NDRange items, group;
    if (side_by_side > 1) {
      SetArguments(kernel, image_buffer, cl_long{image.stride_bytes}, cl_int{image.width},
                   cl_int{image.height}, cl_int{window_pixels / 2}, x_buffer, y_buffer, u_buffer,
                   v_buffer, cl_int{grid.columns()}, result.buffer(), cl_long{out.stride});
      items = cl::NDRange(WholeGroups(grid.columns(), side_by_side), grid.rows());
      group = cl::NDRange(side_by_side, 1);
    } else {
      const int rows_per_item = (grid.rows() + kMaxBands - 1) / kMaxBands;
      const int bands = (grid.rows() + rows_per_item - 1) / rows_per_item;
      const size_t scratch_ints =
          2 * static_cast<size_t>(image.width) * image.channels + image.channels;
      scratch = ScratchBuffer(context, bands * scratch_ints * sizeof(cl_int));
      SetArguments(kernel, image_buffer, cl_long{image.stride_bytes}, cl_int{image.width},
                   cl_int{image.height}, cl_int{window_pixels / 2}, x_buffer, y_buffer, u_buffer,
                   v_buffer, cl_int{grid.columns()}, cl_int{grid.rows()}, cl_int{rows_per_item},
                   scratch, result.buffer(), cl_long{out.stride});
      items = cl::NDRange(bands);
      group = cl::NDRange(1);
    }
    const cl::CommandQueue& queue = workspace->queue();
    const CommandsEnd end(queue);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, items, group);
    result.Finish(queue);
  }));
  context.GiveBack(std::move(workspace));
  return absl::OkStatus();
}

absl::Status BoxMeansAt(Context& context, const ImageView& image, ConstMatrixView<double> points,
                        int window_pixels, MatrixView<float> out) {
  if (points.rows == 0) return absl::OkStatus();
  constexpr char kDoing[] = "computing box means";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  EGOSIEVE_ASSIGN_OR_RETURN(
      cl::Kernel kernel,
      workspace->Kernel("image.cl", BuildOptions(image.channels), "box_means_at"));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const PixelNormalization map = NormalizationForImage(image.width, image.height);
    std::vector<cl_int> pixels;
    std::vector<float> coordinates;
    for (int64_t i = 0; i < points.rows; ++i) {
      pixels.push_back(NearestPixel(points(i, 0), image.width));
      pixels.push_back(NearestPixel(points(i, 1), image.height));
      coordinates.push_back(static_cast<float>(points(i, 0) * map.scale + map.u_offset));
      coordinates.push_back(static_cast<float>(points(i, 1) * map.scale + map.v_offset));
    }
    const cl::Buffer image_buffer = ImageBuffer(context, image);
    const cl::Buffer pixel_buffer = InputBuffer(context, pixels);
    const cl::Buffer coordinate_buffer = InputBuffer(context, coordinates);
    OutputBuffer<float> result(context, out, Unwritten::kPadding);
    SetArguments(kernel, image_buffer, cl_long{image.stride_bytes}, cl_int{image.width},
                 cl_int{image.height}, cl_int{window_pixels / 2}, pixel_buffer, coordinate_buffer,
                 cl_long{points.rows}, result.buffer(), cl_long{out.stride});
    const cl::CommandQueue& queue = workspace->queue();
    const CommandsEnd end(queue);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                               cl::NDRange(WholeGroups(points.rows, kGroupPoints)),
                               cl::NDRange(kGroupPoints));
    result.Finish(queue);
  }));
  context.GiveBack(std::move(workspace));
  return absl::OkStatus();
}

absl::Status GridInterpolation(Context& context, const ImageGrid& grid,
                               ConstMatrixView<float> values, MatrixView<float> out) {
  constexpr char kDoing[] = "interpolating a grid";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context.Borrow(kDoing));
  const int64_t side_by_side = SideBySide(context);
  EGOSIEVE_ASSIGN_OR_RETURN(
      cl::Kernel kernel,
      workspace->Kernel("image.cl", BuildOptions(1),
                        side_by_side > 1 ? "grid_interpolation_by_pixel" : "grid_interpolation"));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const cl::Buffer value_buffer = InputBuffer(context, values);
    OutputBuffer<float> result(context, out, Unwritten::kPadding);
    SetArguments(kernel, value_buffer, cl_long{values.stride}, cl_int{grid.columns()},
                 cl_int{grid.rows()}, cl_int{grid.stride}, cl_int{grid.width}, cl_int{grid.height},
                 result.buffer(), cl_long{out.stride});
    const cl::CommandQueue& queue = workspace->queue();
    const CommandsEnd end(queue);
    if (side_by_side > 1) {
      queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                                 cl::NDRange(WholeGroups(grid.width, side_by_side), grid.height),
                                 cl::NDRange(side_by_side, 1));
    } else {
      queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(grid.height), cl::NDRange(1));
    }
    result.Finish(queue);
  }));
  context.GiveBack(std::move(workspace));
  return absl::OkStatus();
}

}  // namespace egosieve::kernels::opencl
