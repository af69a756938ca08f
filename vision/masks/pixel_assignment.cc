#include "vision/masks/pixel_assignment.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr float kLevels = 8.0f;    // of 255
constexpr double kPixels = 1.5;    // per step between frames
constexpr float kDistance = 5.0f;  // pixels
constexpr float kNewCost = 7.0f;
constexpr int kReachPixels = 48;  // around the expected place of a mover
constexpr float kMostPicture = 3.0f, kMostMotion = 3.0f, kMostDistance = 2.0f, kMostColour = 2.0f;
// Added to the shares of a colour: a colour that was hardly seen in a mover may still be its own.
constexpr double kColourFloor = 0.004;
constexpr int kSide = 5;

struct Sides {
  cv::Mat1f before, after;  // agreement of flow to either side with its return
};

// The positions of each pixel of `area` in the previous and in the next picture.
struct Places {
  cv::Mat2f before, after;
};

// The area in which the mover that had `box` may be.
cv::Rect AreaOf(const cv::Rect& box, const MoverMotion& motion, cv::Size size) {
  cv::Point2d least(1e9, 1e9), most(-1e9, -1e9);
  for (const cv::Point corner :
       {box.tl(), cv::Point(box.br().x, box.y), box.br(), cv::Point(box.x, box.br().y)}) {
    const cv::Point2d moved = cv::Point2d(corner) + motion.At(corner);
    least = {std::min(least.x, moved.x), std::min(least.y, moved.y)};
    most = {std::max(most.x, moved.x), std::max(most.y, moved.y)};
  }
  const auto within = [](double value, int last) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(last)));
  };
  return {cv::Point(within(least.x - kReachPixels, size.width),
                    within(least.y - kReachPixels, size.height)),
          cv::Point(within(most.x + kReachPixels, size.width),
                    within(most.y + kReachPixels, size.height))};
}

Places PlacesOf(const cv::Rect& area, const MoverMotion& motion) {
  Places places{cv::Mat2f(area.size()), cv::Mat2f(area.size())};
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      const cv::Point2d here(area.x + x, area.y + y);
      const cv::Point2d source = motion.Source(here), step = motion.At(here);
      places.before(y, x) = {static_cast<float>(source.x), static_cast<float>(source.y)};
      places.after(y, x) = {static_cast<float>(here.x + step.x),
                            static_cast<float>(here.y + step.y)};
    }
  }
  return places;
}

// Mean over 5 x 5 pixels of the difference between a picture and another at `places`.
cv::Mat1f PictureDifference(const cv::Mat3b& here, const cv::Mat3b& other,
                            const cv::Mat2f& places) {
  cv::Mat3b sampled, difference;
  cv::remap(other, sampled, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::absdiff(here, sampled, difference);
  cv::Mat1f mean;
  const cv::Matx13f third(1.0f / 3.0f, 1.0f / 3.0f, 1.0f / 3.0f);
  cv::Mat3f values;
  difference.convertTo(values, CV_32F);
  cv::transform(values, mean, third);
  cv::boxFilter(mean, mean, -1, {kSide, kSide});
  return mean;
}

// M_k times its weight, and the weight.
void AddMotion(const cv::Rect& area, const cv::Mat2f& places, const cv::Mat& flow,
               const cv::Mat1f& agreement, double pixels, cv::Mat1f& sum, cv::Mat1f& weight) {
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      const cv::Vec2f& step = flow.at<cv::Vec2f>(area.y + y, area.x + x);
      const cv::Vec2f& place = places(y, x);
      const float distance = std::hypot(static_cast<float>(area.x + x) + step[0] - place[0],
                                        static_cast<float>(area.y + y) + step[1] - place[1]);
      const float w = agreement(area.y + y, area.x + x);
      sum(y, x) += w * std::min(distance / static_cast<float>(pixels), kMostMotion);
      weight(y, x) += w;
    }
  }
}

// C_k of every colour, for each mover.
std::vector<std::array<float, kMoverColours>> ColourCosts(const std::vector<KnownMover>& movers) {
  std::vector<std::array<float, kMoverColours>> costs(movers.size());
  for (int colour = 0; colour < kMoverColours; ++colour) {
    double largest = 0.0;
    for (const KnownMover& mover : movers) largest = std::max(largest, (*mover.colours)[colour]);
    for (size_t k = 0; k < movers.size(); ++k) {
      const double share = (*movers[k].colours)[colour];
      costs[k][colour] =
          std::min(static_cast<float>(std::log((largest + kColourFloor) / (share + kColourFloor))),
                   kMostColour);
    }
  }
  return costs;
}

// The terms of (PX1) of mover k before their mean is taken.
cv::Mat1f CostsOf(const AssignmentPictures& pictures, const Sides& sides, const cv::Rect& area,
                  const cv::Mat1f& distance, const MoverMotion& motion,
                  const std::array<float, kMoverColours>& colour_costs) {
  const Places places = PlacesOf(area, motion);
  const cv::Mat3b now = pictures.now.image(area);
  cv::Mat1f difference = PictureDifference(now, pictures.before.image, places.before);
  cv::Mat1f sum = cv::Mat1f::zeros(area.size()), weight = cv::Mat1f::zeros(area.size());
  AddMotion(area, places.before, pictures.now.flow.backward, sides.before, kPixels, sum, weight);
  const TrackedFrame& after = pictures.after;
  if (!after.image.empty()) {
    difference = cv::min(difference, PictureDifference(now, after.image, places.after));
    // A mover's speed may change a little from one step to the next.
    const double pixels = kPixels + 0.1 * cv::norm(motion.shift);
    AddMotion(area, places.after, after.flow.forward, sides.after, pixels, sum, weight);
  }
  cv::Mat1f away;
  cv::remap(distance, away, places.before, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::Mat1f costs(area.size());
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      costs(y, x) = std::min(difference(y, x) / kLevels, kMostPicture) +
                    sum(y, x) / std::max(weight(y, x), 1.0f) +
                    std::min(away(y, x) / kDistance, kMostDistance) +
                    colour_costs[ColourOf(now(y, x))];
    }
  }
  return costs;
}

}  // namespace

double ColourDistance(const ColourShares& a, const ColourShares& b) {
  double overlap = 0.0;
  for (size_t i = 0; i < a.size(); ++i) overlap += std::sqrt(a[i] * b[i]);
  return std::sqrt(std::max(0.0, 1.0 - overlap));
}

cv::Mat1w AssignPixels(const AssignmentPictures& pictures, const cv::Mat1w& last,
                       const std::vector<KnownMover>& movers) {
  const cv::Size size = pictures.mask.size();
  cv::Mat1w numbers = cv::Mat1w::zeros(size);
  Sides sides{AgreementOf(pictures.now.errors.backward, 1.0), {}};
  if (!pictures.after.image.empty()) {
    sides.after = AgreementOf(pictures.after.errors.forward, 1.0);
  }
  cv::Mat1f inside, count;
  cv::Mat1b(pictures.mask != 0).convertTo(inside, CV_32F, 1.0 / 255.0);
  cv::boxFilter(inside, count, -1, {kSide, kSide}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Mat1f best(size, kNewCost);
  const auto colour_costs = ColourCosts(movers);
  for (size_t k = 0; k < movers.size(); ++k) {
    const cv::Mat1b before = last == movers[k].number;
    const cv::Rect box = cv::boundingRect(before);
    const cv::Rect area = AreaOf(box, movers[k].motion, size);
    if (box.empty() || area.empty()) continue;
    cv::Mat1f distance;
    cv::distanceTransform(before == 0, distance, cv::DIST_L2, cv::DIST_MASK_5);
    cv::Mat1f costs = CostsOf(pictures, sides, area, distance, movers[k].motion, colour_costs[k]);
    costs = costs.mul(inside(area));
    cv::boxFilter(costs, costs, -1, {kSide, kSide}, {-1, -1}, false, cv::BORDER_CONSTANT);
    for (int y = 0; y < area.height; ++y) {
      for (int x = 0; x < area.width; ++x) {
        const cv::Point place(area.x + x, area.y + y);
        if (pictures.mask(place) == 0) continue;
        const float cost = costs(y, x) / count(place);
        if (cost >= best(place)) continue;
        best(place) = cost;
        numbers(place) = movers[k].number;
      }
    }
  }
  return numbers;
}

}  // namespace egosieve::vision
