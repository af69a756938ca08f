#include "vision/image/node_grid.h"

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

TEST(NodesOf, CountsEveryPixelOfTheGridThatIsInThePicture) {
  for (const int stride : {1, 2, 5, 8}) {
    for (int pixels = 0; pixels <= 30; ++pixels) {
      int count = 0;
      for (int x = stride / 2; x < pixels; x += stride) ++count;
      EXPECT_EQ(NodesOf({pixels, 40}, stride).width, count) << pixels << " / " << stride;
      EXPECT_EQ(NodesOf({40, pixels}, stride).height, count) << pixels << " / " << stride;
    }
  }
}

TEST(NodeGrid, NodesArePlacedRowByRowAndFoundAgain) {
  const int stride = 5;
  const cv::Size nodes = NodesOf({23, 12}, stride);
  ASSERT_EQ(nodes, cv::Size(5, 2));
  EXPECT_EQ(PlaceOfNode(0, nodes.width, stride), cv::Point2f(2, 2));
  EXPECT_EQ(PlaceOfNode(7, nodes.width, stride), cv::Point2f(12, 7));
  EXPECT_EQ(PlaceOfNode(cv::Point(4, 1), stride), cv::Point2f(22, 7));
  for (int node = 0; node < nodes.area(); ++node) {
    const cv::Point2f place = PlaceOfNode(node, nodes.width, stride);
    EXPECT_EQ(NodeAt(place.x, place.y, nodes.width, stride), node);
    EXPECT_EQ(NearestNode(place, nodes, stride), node);
  }
}

TEST(NearestNode, IsTheNearestAlsoOutsideOfTheGrid) {
  const cv::Size nodes(5, 2);  // columns at 2, 7, ..., 22, rows at 2 and 7
  EXPECT_EQ(NearestNode({9.4f, 2.0f}, nodes, 5), 1);
  EXPECT_EQ(NearestNode({9.6f, 2.0f}, nodes, 5), 2);
  EXPECT_EQ(NearestNode({2.0f, 4.6f}, nodes, 5), 5);
  EXPECT_EQ(NearestNode({-40.0f, -1.0f}, nodes, 5), 0);
  EXPECT_EQ(NearestNode({1000.0f, 1000.0f}, nodes, 5), 9);
}

}  // namespace
}  // namespace egosieve::vision
