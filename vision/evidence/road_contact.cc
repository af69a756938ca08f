#include "vision/evidence/road_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "vision/evidence/column_contact.h"
#include "vision/evidence/for_each_point.h"
#include "vision/evidence/surfaces.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kSlack = 0.25;  // of the road's inverse depth: hollows and slopes far ahead
constexpr double kMostRoadRatio = 6.0;
constexpr double kLeastDepth = 0.1;  // in the first frame, of the depth in the second
// Of a surface: the share of its columns with a contact for which its ratio counts in full; the
// greatest factor by which the ratio grows with their number; and the greatest rise above the
// camera, in camera heights.
constexpr double kEnoughColumns = 0.5, kMostWeight = 1.5, kSurfaceRise = 1.5;

// A static point is at or above the road, a mover anywhere: so only what seems to lie below, z < 0,
// is evidence, by the normal distribution. The deviations include the unevenness of roads.
double RoadLogRatio(double z) {
  if (!(z < 0.0)) return 0.0;
  return std::min(kMostRoadRatio, -std::log(std::erfc(-z / std::sqrt(2.0))));
}

// Ground contacts of the columns of one surface.
struct SurfaceVotes {
  int columns = 0, last_column = -1;                       // columns with the surface in them
  int last_judged = -1;                                    // last column with a contact
  std::vector<double> too_far, too_near;                   // of the columns with a contact
  double fall = 0.0;                                       // of their contacts, the sum
  double rise = -std::numeric_limits<double>::infinity();  // the greatest

  void Add(const ContactRatios& contact, const RoadPlane& road) {
    too_far.push_back(contact.too_far);
    too_near.push_back(contact.too_near);
    fall += contact.ground / road.m(1);
  }
  double LogRatio() {
    const auto judged = static_cast<double>(too_far.size());
    if (judged == 0.0 || rise > kSurfaceRise * fall / judged) return 0.0;
    return std::max(MedianInPlace(too_far), MedianInPlace(too_near)) *
           std::min(kMostWeight, std::sqrt(judged)) *
           std::min(1.0, judged / columns / kEnoughColumns);
  }
};

// For each point the ratio of its surface, from the medians over the surface's columns.
std::vector<double> RatiosBySurface(const ColumnView& view,
                                    const std::vector<PointContact>& contacts) {
  const std::vector<InverseDepth>& points = view.points;
  std::vector<bool> is_part(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    is_part[i] = points[i].valid && view.grounds[i] != Ground::kRoad;
  }
  const std::vector<int> surfaces = FindSurfaces(view.raster, points, is_part);
  std::vector<SurfaceVotes> votes(points.size());
  for (int column = 0; column < view.raster.columns(); ++column) {
    for (int row = view.raster.rows() - 1; row >= 0; --row) {
      const int i = view.raster.At(row, column);
      if (i < 0 || surfaces[i] < 0) continue;
      SurfaceVotes& own = votes[surfaces[i]];
      own.columns += own.last_column != column;
      own.last_column = column;
      own.rise = std::max(own.rise, -view.road.Fall(points[i].ray));
      if (!contacts[i].judged || own.last_judged == column) continue;
      own.last_judged = column;
      own.Add(contacts[i].ratios, view.road);
    }
  }
  std::vector<double> of_surfaces, ratios(points.size(), 0.0);
  for (SurfaceVotes& own : votes) of_surfaces.push_back(own.LogRatio());
  for (size_t i = 0; i < points.size(); ++i) {
    if (surfaces[i] >= 0) ratios[i] = of_surfaces[surfaces[i]];
  }
  return ratios;
}

// Position in the first frame of a point of the road that is at `place` in the second; nullopt
// above the horizon.
std::optional<cv::Point2f> PlaceOfRoadBefore(const RoadPlane& road, const Pinhole& camera,
                                             const RelativePose& back, cv::Point2f place) {
  const Eigen::Vector3d ray = camera.Ray(place.x, place.y);
  const double inverse_depth = road.At(ray);
  const Eigen::Vector3d point = back.rotation * ray + inverse_depth * back.translation;
  if (!(inverse_depth > 0.0) || !(point(2) > kLeastDepth)) return std::nullopt;
  const Eigen::Vector2d before = camera.Project(point);
  return cv::Point2f(static_cast<float>(before(0)), static_cast<float>(before(1)));
}

}  // namespace

void CompareWithRoad(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose,
                     const PhotometricSupport& pictures, const std::vector<PointPair>& pairs,
                     std::vector<InverseDepth>& points) {
  const RelativePose back = Inverse(pose);
  const PhotometricSupport reversed = pictures.Reversed();
  ForEachPoint(points.size(), [&](size_t i) {
    if (!points[i].valid) return;
    const cv::Point2f now(static_cast<float>(pairs[i].x2), static_cast<float>(pairs[i].y2));
    const cv::Point2f before(static_cast<float>(pairs[i].x1), static_cast<float>(pairs[i].y1));
    const std::optional<cv::Point2f> as_road = PlaceOfRoadBefore(road, camera, back, now);
    if (as_road) points[i].against_road = reversed.LogRatio(now, before, *as_road).value_or(0.0);
  });
}

std::vector<double> RoadLogRatios(const RoadPlane& road, const std::vector<InverseDepth>& points,
                                  const std::vector<cv::Point2f>& places, cv::Size image,
                                  const ContactPictures* pictures) {
  std::vector<double> ratios(points.size(), 0.0);
  std::vector<Ground> grounds(points.size(), Ground::kUnclear);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!points[i].valid) continue;
    grounds[i] = GroundOf(road, points[i]);
    const double at = road.At(points[i].ray);
    if (!(at > 0.0)) continue;
    const double deviation = std::hypot(points[i].deviation, kRoadUnevenness * at);
    const double below = RoadLogRatio((points[i].value - (1.0 - kSlack) * at) / deviation);
    ratios[i] = std::min(below, std::max(0.0, points[i].against_road));
  }
  const Raster raster(places, image);
  const ColumnView view{raster, road, points, places, grounds, pictures};
  const std::vector<PointContact> contacts = ContactsByColumn(view);
  const std::vector<double> by_surface = RatiosBySurface(view, contacts);
  for (size_t i = 0; i < points.size(); ++i) {
    const int representative = raster.RepresentativeOf(places[i]);
    if (!points[i].valid || !points[representative].valid ||
        !IsAlike(points[i], points[representative])) {
      continue;
    }
    ratios[i] =
        std::max({ratios[i], contacts[representative].ratios.too_far, by_surface[representative]});
  }
  return ratios;
}

}  // namespace egosieve::vision
