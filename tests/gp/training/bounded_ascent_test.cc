#include "gp/training/bounded_ascent.h"

#include <cmath>
#include <limits>
#include <vector>

#include "absl/status/status.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

HyperparameterBounds Box(std::vector<double> lower, std::vector<double> upper) {
  HyperparameterBounds bounds;
  bounds.lower = std::move(lower);
  bounds.upper = std::move(upper);
  return bounds;
}

// Minus Rosenbrock's function; its maximum in the plane is 0 at (1, 1).
absl::StatusOr<double> Valley(const std::vector<double>& x, std::vector<double>& gradient) {
  const double a = 1.0 - x[0], b = x[1] - x[0] * x[0];
  gradient = {2.0 * a + 400.0 * x[0] * b, -200.0 * b};
  return -(a * a + 100.0 * b * b);
}

AscentOptions Tight() {
  AscentOptions options;
  options.tolerance = 1e-9;
  return options;
}

TEST(BoundedAscent, FindsTheMaximumOfACurvedValley) {
  const auto found = Value(Ascend(Valley, {-1.2, 1.0}, Box({-5, -5}, {5, 5}), Tight()));
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.theta[0], 1.0, 1e-7);
  EXPECT_NEAR(found.theta[1], 1.0, 1e-7);
}

TEST(BoundedAscent, EndsOnABoundWhereTheGradientPointsOut) {
  // With x <= 1/2 the maximum lies at x = 1/2, y = 1/4.
  const auto found = Value(Ascend(Valley, {-1.2, 1.0}, Box({-5, -5}, {0.5, 5}), Tight()));
  EXPECT_TRUE(found.converged);
  EXPECT_EQ(found.theta[0], 0.5);
  EXPECT_NEAR(found.theta[1], 0.25, 1e-9);
  EXPECT_LE(found.gradient_norm, 1e-9);
}

TEST(BoundedAscent, EveryPlaceThatIsAskedLiesWithinTheBounds) {
  const HyperparameterBounds bounds = Box({-2, 0.5}, {0.5, 0.75});
  const auto found = Ascend(
      [&](const std::vector<double>& x, std::vector<double>& gradient) {
        EXPECT_TRUE(bounds.Contains(x)) << x[0] << ", " << x[1];
        return Valley(x, gradient);
      },
      {9.0, -9.0}, bounds);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_TRUE(bounds.Contains(found->theta));
}

TEST(BoundedAscent, GoesAroundPlacesWithoutAValue) {
  // log x has no value below 0; log x - x has its maximum at 1.
  const auto found = Ascend(
      [](const std::vector<double>& x, std::vector<double>& gradient) -> absl::StatusOr<double> {
        gradient = {x[0] > 0.0 ? 1.0 / x[0] - 1.0 : 0.0};
        return x[0] > 0.0 ? std::log(x[0]) - x[0] : -std::numeric_limits<double>::infinity();
      },
      {9.0}, Box({-100}, {100}), Tight());
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_NEAR(found->theta[0], 1.0, 1e-8);
}

TEST(BoundedAscent, TellsThatItHasNotConverged) {
  AscentOptions few;
  few.steps = 2;
  const auto found = Value(Ascend(Valley, {-1.2, 1.0}, Box({-5, -5}, {5, 5}), few));
  EXPECT_FALSE(found.converged);
  EXPECT_GT(found.gradient_norm, few.tolerance);
  std::vector<double> gradient;
  EXPECT_GT(found.value, *Valley({-1.2, 1.0}, gradient));
}

TEST(BoundedAscent, ReturnsTheFunctionsError) {
  const auto found = Ascend(
      [](const std::vector<double>&, std::vector<double>&) -> absl::StatusOr<double> {
        return absl::CancelledError("enough");
      },
      {0.0}, Box({-1}, {1}));
  EXPECT_EQ(found.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace egosieve::gp
