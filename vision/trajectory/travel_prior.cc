#include "vision/trajectory/travel_prior.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

constexpr int kIterations = 60;
// Because of sideslip, pitch and bumps no direction of a vehicle is known better than to 3 degrees.
constexpr double kGreatestConcentration = 400.0;
constexpr double kLeastConcentration = 1.0;
// Of a vehicle: 3.5 degrees. The directions of one that drives spread by up to 2, on a mount that
// shakes by 3.3, those of a camera that a person carries by more than 6, if he pans also by 4.
constexpr double kLeastOfVehicle = 270.0;
constexpr double kStartConcentration = 100.0;
constexpr double kStartShare = 0.5;
// For the share: counts as this many additional directions away from the mean.
constexpr double kOthersAssumed = 2.0;

// The first density of (TP1): 2 k / (1 - exp(-2 k)) exp(k (cosine - 1)).
double Peak(double concentration, double cosine) {
  return 2.0 * concentration / -std::expm1(-2.0 * concentration) *
         std::exp(concentration * (cosine - 1.0));
}

// The direction with which most others agree.
Eigen::Vector3d StartOf(const std::vector<Eigen::Vector3d>& directions) {
  Eigen::Vector3d best = directions[0];
  double best_sum = 0.0;
  for (const Eigen::Vector3d& candidate : directions) {
    double sum = 0.0;
    for (const Eigen::Vector3d& x : directions) sum += Peak(kStartConcentration, candidate.dot(x));
    if (sum > best_sum) {
      best_sum = sum;
      best = candidate;
    }
  }
  return best;
}

}  // namespace

bool TravelPrior::IsOfVehicle() const {
  return share > 0.5 && concentration > kLeastOfVehicle && MovesForwardOrBack(direction);
}

double TravelPrior::LogDensity(const Eigen::Vector3d& x) const {
  return std::log(share * Peak(concentration, direction.dot(x)) + 1.0 - share);
}

double TravelPrior::Membership(const Eigen::Vector3d& x) const {
  const double peak = share * Peak(concentration, direction.dot(x));
  return peak / (peak + 1.0 - share);
}

TravelPrior FitTravelPrior(const std::vector<Eigen::Vector3d>& directions) {
  TravelPrior prior;
  if (directions.size() < size_t{TravelPrior::kFewestDirections}) return prior;
  prior.direction = StartOf(directions);
  prior.concentration = kStartConcentration;
  prior.share = kStartShare;
  const auto count = static_cast<double>(directions.size());
  for (int k = 0; k < kIterations; ++k) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double members = 0.0;
    for (const Eigen::Vector3d& x : directions) {
      const double weight = prior.Membership(x);
      members += weight;
      sum += weight * x;
    }
    const double length = sum.norm();
    if (!(length > 0.0)) return {};
    const double mean = std::min(length / members, 1.0 - 1e-9);  // resultant length
    prior.direction = sum / length;
    prior.concentration = std::clamp(mean * (3.0 - mean * mean) / (1.0 - mean * mean),
                                     kLeastConcentration, kGreatestConcentration);
    prior.share = members / (count + kOthersAssumed);
  }
  return prior;
}

}  // namespace egosieve::vision
