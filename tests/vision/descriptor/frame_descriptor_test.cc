#include "vision/descriptor/frame_descriptor.h"

#include <random>
#include <vector>

#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

Frame RandomFrame(int width, int height) {
  Frame frame;
  frame.image.create(height, width, CV_8UC3);
  std::mt19937_64 engine(4);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < 3 * width; ++x) frame.image.ptr(y)[x] = static_cast<uint8_t>(engine());
  }
  return frame;
}

// One code path: what is learnt at a pixel is what is inferred there.
TEST(FrameDescriptor, PositionsAndGridAgreeBitForBit) {
  const Frame frame = RandomFrame(53, 31);
  ImageGrid grid{.width = 53, .height = 31, .stride = 5};
  std::vector<double> positions;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      positions.push_back(grid.x_pixels(column));
      positions.push_back(grid.y_pixels(row));
    }
  }
  const auto field = Value(DescribeGrid(frame, grid));
  const auto points = Value(
      DescribePositions(frame, kernels::ConstMatrixView<double>(positions.data(), grid.size(), 2)));
  EXPECT_EQ(field, points);
  ASSERT_EQ(field.size(), static_cast<size_t>(6 * grid.size()));
  EXPECT_FLOAT_EQ(field[0], -1.0F) << "u of the left border";
}

// A cut-out shares its parent's rows: the stride must be honoured.
TEST(FrameDescriptor, ViewsIntoLargerImages) {
  const Frame whole = RandomFrame(60, 40);
  Frame part = whole, copy = whole;
  part.image = whole.image(cv::Rect(10, 5, 30, 20));
  copy.image = part.image.clone();
  const std::vector<double> position = {14.0, 9.0};
  const kernels::ConstMatrixView<double> view(position.data(), 1, 2);
  EXPECT_EQ(*DescribePositions(part, view), *DescribePositions(copy, view));
}

TEST(FrameDescriptor, BadInputIsAnError) {
  Frame frame = RandomFrame(20, 10);
  EXPECT_FALSE(DescribeGrid(frame, {.width = 21, .height = 10}).ok()) << "another size";
  frame.image = cv::Mat();
  EXPECT_FALSE(DescribePositions(frame, {}).ok());
  frame.image = cv::Mat(10, 20, CV_8UC1, cv::Scalar(0));
  EXPECT_FALSE(DescribePositions(frame, {}).ok());
}

}  // namespace
}  // namespace egosieve::vision
