// scikit-learn 1.2.2's numbers: kernels of sklearn.gaussian_process.kernels times
// ConstantKernel(1.3^2), and GaussianProcessRegressor(alpha=0.2^2, optimizer=None) on five points.
// RBF, Matern(nu=0.5, 1.5, 2.5), RationalQuadratic, DotProduct (isotropic(linear) + constant),
// ConstantKernel, ExpSineSquared, their sums and products.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "gp/model/exact_model.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/runtime/context.h"
#include "tests/kernels/covariance/expressions.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

struct Numbers {
  const char* function;
  std::vector<double> scales;
  int64_t dimension;  // the first of the inputs' columns
  // k(x_1, x_0), k(x_2, x_1), k(x_3, x_0), k(x_4, x_2); the log likelihood; means at the two
  // queries, variances there.
  std::array<double, 9> values;
};

const std::vector<Numbers>& AllNumbers() {
  static const auto& numbers = *new std::vector<Numbers>{
      {"squared_exponential",
       {0.7, 1.1, 0.4},
       3,
       {0.033303491883287385, 0.11178337626349766, 1.6900000000000002, 0.63009549946925925,
        -5.0234311879198561, 0.48163401578508613, -0.029726317611489347, 0.89414546218964264,
        1.3242336014547409}},
      {"matern12",
       {0.7, 1.1, 0.4},
       3,
       {0.10251904613041171, 0.16432605336952111, 1.6900000000000002, 0.41478843531161802,
        -5.012410230846192, 0.24450282824741176, 0.0015166130322872007, 1.367455001883725,
        1.5204781835402108}},
      {"matern32",
       {0.7, 1.1, 0.4},
       3,
       {0.077141548186026795, 0.1502765787801717, 1.6900000000000002, 0.50922568540240587,
        -5.0179840573209615, 0.35496737961676772, -0.01276096665369216, 1.1752684132737279,
        1.446909490697494}},
      {"matern52",
       {0.7, 1.1, 0.4},
       3,
       {0.065327694817114507, 0.14069087699420266, 1.6900000000000002, 0.54290637198124136,
        -5.0197304987671609, 0.39736609230829517, -0.017962304725778522, 1.0944899554585017,
        1.4168149523213756}},
      {"isotropic(rational_quadratic)",
       {1.3, 0.6},
       3,
       {0.38235118574299237, 0.31613446951609253, 1.6900000000000002, 0.40181070519527406,
        -4.9909808850522701, 0.32231735806826789, -0.217504079599984, 0.89397137677553551,
        0.90498766002769426}},
      {"isotropic(linear) + constant",
       {1.0, 0.9},
       3,
       {1.0309000000000004, 0.59994999999999998, 2.4843000000000002, 1.7280250000000001,
        -5.9642410947383491, -0.012524491235996088, -0.22402668351346183, 0.012004509147588216,
        0.024008779822776383}},
      {"constant",
       {},
       3,
       {1.6900000000000002, 1.6900000000000002, 1.6900000000000002, 1.6900000000000002,
        -21.834895528227122, 0.16919905771496038, 0.16919905771496038, 0.0079623085983511182,
        0.0079623085983511182}},
      {"isotropic(matern52) * isotropic(squared_exponential) + isotropic(linear) * constant",
       {0.8, 1.5, 0.6, 1.0},
       3,
       {0.089723135544221455, -0.13320903111936711, 2.0915440000000003, 0.36172421258975263,
        -5.4174721601779776, 0.30129759133206152, -0.28129760800936549, 1.0038821728270915,
        1.0393703301018606}},
      {"periodic",
       {0.8, 1.7},
       1,
       {0.076255408160011917, 1.1240407014746456, 1.6900000000000002, 0.40917916631740547,
        -5.5098752925944332, 0.34639169771832845, -0.67471569796722553, 0.33466576970025685,
        0.056676221899629287}},
      {"(isotropic(periodic) + isotropic(matern32)) * squared_exponential",
       {0.8, 1.7, 0.5, 0.3, 2.0},
       1,
       {0.092010170468583244, 0.84900447032209281, 2.1125000000000003, 0.53719942822194577,
        -5.3829307413779297, 0.35018192332748288, -0.78899897375530881, 0.42904416172330762,
        0.338178113855296}}};
  return numbers;
}

constexpr double kInputs[5][3] = {
    {0.1, -0.4, 0.7}, {0.9, 0.2, -0.3}, {-0.6, 0.5, 0.05}, {0.1, -0.4, 0.7}, {-1.0, -0.8, 0.25}};
constexpr double kTargets[5] = {0.3, -0.7, 1.1, 0.35, -0.2};
constexpr double kQueries[2][3] = {{0.0, 0.0, 0.0}, {0.8, -0.1, 0.3}};

TEST(ScikitLearn, AgreesOnCovariancesLikelihoodAndPosterior) {
  const auto context = Value(kernels::OpenContext());
  for (const Numbers& numbers : AllNumbers()) {
    SCOPED_TRACE(numbers.function);
    Hyperparameters theta;
    theta.covariance.function = kernels::Function(numbers.function);
    theta.covariance.scales = numbers.scales;
    theta.covariance.signal_stddev = 1.3;
    theta.covariance.dimension = numbers.dimension;
    theta.noise_stddev = 0.2;
    const kernels::ConstMatrixView<double> x(&kInputs[0][0], 5, numbers.dimension, 3);
    const kernels::ConstMatrixView<double> queries(&kQueries[0][0], 2, numbers.dimension, 3);
    double k[5][5];
    ASSERT_TRUE(kernels::CovarianceMatrix(*context, theta.covariance, x, 0.0,
                                          kernels::Triangle::kFull, {&k[0][0], 5, 5})
                    .ok());
    auto model = Value(ExactModel::Create(context, theta));
    ASSERT_TRUE(model.AddObservations({x, kTargets}, 0).ok());
    double mean[2], variance[2];
    ASSERT_TRUE(Value(model.MakeFloat64Posterior())->Evaluate(queries, mean, variance).ok());
    const std::array<double, 9> values = {
        k[1][0], k[2][1], k[3][0],     k[4][2],    model.LogMarginalLikelihood(),
        mean[0], mean[1], variance[0], variance[1]};
    for (size_t i = 0; i < values.size(); ++i) {
      // 1e-10 of the number: far above float64's rounding at these condition numbers, below 1e3.
      const double expected = numbers.values[i];
      EXPECT_NEAR(values[i], expected, 1e-10 * std::max(1.0, std::abs(expected))) << i;
    }
  }
}

}  // namespace
}  // namespace egosieve::gp
