#include "tools/segment/feature_dump.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "gp/io/array_file.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "vision/descriptor/frame_descriptor.h"
#include "vision/frame/equalization.h"

namespace egosieve::tools {
namespace {

constexpr int64_t kInputs = vision::kDescriptorDimension;

template <typename Number>
gp::NamedArray Table(const std::vector<Number>& elements, int64_t columns) {
  const int64_t rows = static_cast<int64_t>(elements.size()) / columns;
  return {{rows, columns}, std::vector<double>(elements.begin(), elements.end())};
}

}  // namespace

absl::Status DumpFeatures(const vision::SegmentedFrame& frame, kernels::Context& context,
                          const vision::OnlineSegmenterOptions& options,
                          const std::string& directory) {
  if (frame.damage.has_value()) return absl::OkStatus();
  const vision::LabelledFrame& labels = frame.labels;
  const auto equalized = [&](vision::Frame picture) {
    picture.image = vision::EqualizeLuminance(picture.image, options.labeller.equalization);
    return picture;
  };
  const cv::Size size = frame.frame.image.size();
  const kernels::ImageGrid grid{size.width, size.height, options.stride_pixels};
  EGOSIEVE_ASSIGN_OR_RETURN(
      const std::vector<float> field,
      vision::DescribeGrid(context, equalized(frame.frame), grid, options.descriptor));
  std::vector<float> inputs;
  if (labels.size() > 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        inputs, vision::DescribePositions(context, equalized(labels.labelled),
                                          labels.positions_view(), options.descriptor));
  }
  const gp::ArrayMap arrays = {
      {"frames", gp::VectorArray<int64_t>({frame.index, labels.labelled.index, labels.first_index,
                                           labels.second_index})},
      {"grid", gp::VectorArray<int64_t>({grid.width, grid.height, grid.stride})},
      {"labels", gp::VectorArray(labels.probability)},
      {"inputs", Table(inputs, kInputs)},
      {"field", Table(field, kInputs)},
      {"positions", Table(labels.positions, 2)},
      {"others", Table(labels.other_positions, 2)},
      {"kind", gp::VectorArray<int64_t>({static_cast<int64_t>(labels.motion_model)})},
  };
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, gp::SerializeArrays(arrays));
  return kernels::WriteFileAtomically(absl::StrFormat("%s/%06d.npz", directory, frame.index),
                                      bytes);
}

}  // namespace egosieve::tools
