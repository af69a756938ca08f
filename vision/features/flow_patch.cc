#include "vision/features/flow_patch.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr int kArea = kFlowPatchSide * kFlowPatchSide;
// Added to H: a step along which the picture does not change has no length. Half a grey level of
// noise against displacements of about a pixel.
constexpr float kLeastCurvature = 0.25f;

float Sum(const FlowPatchRow& a) {
  return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
}

}  // namespace

FlowPicture::FlowPicture(const cv::Mat1b& grey) {
  cv::Mat1f levels;
  grey.convertTo(levels, CV_32F);
  cv::copyMakeBorder(levels, padded_, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
}

FlowPatchRows::FlowPatchRows(const FlowPicture& picture, cv::Point2f corner)
    : stride_(static_cast<std::ptrdiff_t>(picture.stride())) {
  constexpr float kFirst = 1 - kFlowPatchSide;
  const cv::Size size = picture.size();
  const float x = std::min(std::max(kFirst, corner.x), static_cast<float>(size.width - 1));
  const float y = std::min(std::max(kFirst, corner.y), static_cast<float>(size.height - 1));
  const float column = std::floor(x), row = std::floor(y);
  right_ = x - column;
  left_ = 1.0f - right_;
  below_ = y - row;
  above_ = 1.0f - below_;
  corner_ = picture.At(static_cast<int>(column), static_cast<int>(row));
}

FlowPatch::FlowPatch(const FlowPicture& picture, cv::Point2f corner) {
  const FlowPatchRows rows(picture, corner);
  // Columns before, at and after the pixels, of the rows above to below.
  std::array<FlowPatchRow, kFlowPatchSide + 2> across, around;
  rows.ForEach(-1, kFlowPatchSide + 1, 1,
               [&](int row, const FlowPatchRow& after) { across[row + 1] = after; });
  rows.ForEach(-1, kFlowPatchSide + 1, -1, [&](int row, const FlowPatchRow& before) {
    around[row + 1] = across[row + 1] + before;
    across[row + 1] -= before;
  });
  FlowPatchRow sum = {}, sum_x = {}, sum_y = {};
  rows.ForEach(-1, kFlowPatchSide + 1, 0, [&](int row, const FlowPatchRow& here) {
    around[row + 1] += 2.0f * here;
    if (row < 0 || row >= kFlowPatchSide) return;
    grey_[row] = here;
    sum += here;
  });
  for (int row = 0; row < kFlowPatchSide; ++row) {
    gradient_x_[row] = 0.125f * (across[row] + 2.0f * across[row + 1] + across[row + 2]);
    gradient_y_[row] = 0.125f * (around[row + 2] - around[row]);
    sum_x += gradient_x_[row];
    sum_y += gradient_y_[row];
  }
  mean_ = Sum(sum) / kArea;
  const float mean_x = Sum(sum_x) / kArea, mean_y = Sum(sum_y) / kArea;
  FlowPatchRow squares = {}, xx = {}, xy = {}, yy = {}, along_x = {}, along_y = {};
  for (int row = 0; row < kFlowPatchSide; ++row) {
    grey_[row] -= mean_;
    const FlowPatchRow x = gradient_x_[row] -= mean_x, y = gradient_y_[row] -= mean_y;
    squares += grey_[row] * grey_[row];
    xx += x * x;
    xy += x * y;
    yy += y * y;
    along_x += x * grey_[row];
    along_y += y * grey_[row];
  }
  squares_ = Sum(squares);
  slope_ = {Sum(along_x), Sum(along_y)};
  const float h_xx = Sum(xx) + kLeastCurvature, h_xy = Sum(xy), h_yy = Sum(yy) + kLeastCurvature;
  const float determinant = h_xx * h_yy - h_xy * h_xy;
  inverse_xx_ = h_yy / determinant;
  inverse_xy_ = -h_xy / determinant;
  inverse_yy_ = h_xx / determinant;
}

// About I's mean, so that little is lost where the patches are alike.
FlowPatchMatch FlowPatch::Compare(const FlowPicture& other, cv::Point2f corner) const {
  FlowPatchRow sum = {}, squares = {}, products = {}, along_x = {}, along_y = {};
  FlowPatchRows(other, corner).ForEach([&](int row, const FlowPatchRow& levels) {
    const FlowPatchRow there = levels - mean_;
    sum += there;
    squares += there * there;
    products += there * grey_[row];
    along_x += there * gradient_x_[row];
    along_y += there * gradient_y_[row];
  });
  const float total = Sum(sum), product = Sum(products);
  const float squares_there = Sum(squares) - total * total / kArea;
  return {squares_ + squares_there - 2.0f * product, product,
          cv::Point2f(Sum(along_x), Sum(along_y)) - slope_};
}

float FlowPatch::Correlation(const FlowPatchMatch& match) const {
  const float squares_there = match.error + 2.0f * match.product - squares_;
  const float norms = std::sqrt(squares_ * std::max(squares_there, 0.0f));
  return norms > 0.0f ? match.product / norms : 0.0f;
}

AlignedFlowPatch FlowPatch::Align(const FlowPicture& other, cv::Point2f start,
                                  int most_steps) const {
  return Align(other, start, Compare(other, start), most_steps);
}

AlignedFlowPatch FlowPatch::Align(const FlowPicture& other, cv::Point2f start,
                                  const FlowPatchMatch& at_start, int most_steps) const {
  cv::Point2f found = start;
  FlowPatchMatch here = at_start;
  for (int step = 0; step < most_steps; ++step) {
    const cv::Point2f next(found.x - (inverse_xx_ * here.slope.x + inverse_xy_ * here.slope.y),
                           found.y - (inverse_xy_ * here.slope.x + inverse_yy_ * here.slope.y));
    if (!(std::hypot(next.x - start.x, next.y - start.y) <= kFlowPatchSide)) break;
    const FlowPatchMatch there = Compare(other, next);
    if (!(there.error < here.error)) break;
    found = next;
    here = there;
  }
  return {found, here};
}

}  // namespace egosieve::vision
