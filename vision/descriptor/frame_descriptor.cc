#include "vision/descriptor/frame_descriptor.h"

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

absl::StatusOr<ImageView> View(const Frame& frame) {
  const cv::Mat& image = frame.image;
  if (image.empty() || image.type() != CV_8UC3) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame ", frame.index, ": the image is empty or not 8-bit BGR"));
  }
  ImageView view;
  view.data = image.data;
  view.width = image.cols;
  view.height = image.rows;
  view.channels = image.channels();
  view.stride_bytes = static_cast<ptrdiff_t>(image.step[0]);
  return view;
}

}  // namespace

absl::StatusOr<std::vector<float>> DescribePositions(const Frame& frame,
                                                     kernels::ConstMatrixView<double> positions,
                                                     const DescriptorOptions& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(const ImageView view, View(frame));
  std::vector<float> inputs(positions.rows * kDescriptorDimension);
  EGOSIEVE_RETURN_IF_ERROR(
      BoxMeansAt(view, positions, options,
                 kernels::MatrixView<float>(inputs.data(), positions.rows, kDescriptorDimension)));
  return inputs;
}

absl::StatusOr<std::vector<float>> DescribeGrid(const Frame& frame, const ImageGrid& grid,
                                                const DescriptorOptions& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(const ImageView view, View(frame));
  EGOSIEVE_RETURN_IF_ERROR(grid.Validate());
  if (grid.width != view.width || grid.height != view.height) {
    return absl::InvalidArgumentError(absl::StrCat("frame ", frame.index, " is ", view.width, "x",
                                                   view.height, ", the grid ", grid.width, "x",
                                                   grid.height));
  }
  std::vector<float> inputs(grid.size() * kDescriptorDimension);
  EGOSIEVE_RETURN_IF_ERROR(
      BoxMeansOnGrid(view, grid, options,
                     kernels::MatrixView<float>(inputs.data(), grid.size(), kDescriptorDimension)));
  return inputs;
}

}  // namespace egosieve::vision
