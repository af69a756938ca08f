// Kriging: estimates a field in the plane from its values at scattered wells, with its uncertainty,
// on a dense grid.
//
//   kriging [--wells=N] [--side=PIXELS] [--device=NAME] [--out=FILE]
//
// Every well gives the field's value with noise. The hyperparameters are fitted to the wells by
// maximum likelihood. The posterior gives the estimate at side x side points: --side=1000 is a
// million. --out writes side * side floats of the mean, then as many of the standard deviation.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "egosieve/gaussian_process.hpp"

namespace {

// The true field: hills of two sizes.
double Field(double x, double y) {
  return std::sin(3.0 * x) * std::cos(2.0 * y) + 0.4 * std::sin(7.0 * x + 4.0 * y);
}

// Random numbers in [0, 1) that are the same on every machine.
class Random {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) / 9007199254740992.0;
  }

 private:
  uint64_t state_ = 1;
};

struct Options {
  int64_t wells = 400;
  int64_t side = 200;
  std::string device, out;
};

bool Parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::string value = argument.substr(argument.find('=') + 1);
    if (argument.rfind("--wells=", 0) == 0) {
      options.wells = std::atoll(value.c_str());
    } else if (argument.rfind("--side=", 0) == 0) {
      options.side = std::atoll(value.c_str());
    } else if (argument.rfind("--device=", 0) == 0) {
      options.device = value;
    } else if (argument.rfind("--out=", 0) == 0) {
      options.out = value;
    } else {
      return false;
    }
  }
  return options.wells > 1 && options.side > 1;
}

bool Write(const std::string& path, const std::vector<float>& mean,
           const std::vector<float>& deviation) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  const bool whole =
      std::fwrite(mean.data(), sizeof(float), mean.size(), file) == mean.size() &&
      std::fwrite(deviation.data(), sizeof(float), deviation.size(), file) == deviation.size();
  return std::fclose(file) == 0 && whole;
}

int Krige(const Options& options) {
  Random random;
  std::vector<double> places(2 * options.wells), values(options.wells);
  for (int64_t i = 0; i < options.wells; ++i) {
    const double x = 2.0 * random() - 1.0, y = 2.0 * random() - 1.0;
    places[2 * i] = x;
    places[2 * i + 1] = y;
    values[i] = Field(x, y) + 0.1 * (random() + random() - 1.0);
  }

  egosieve::GaussianProcessOptions model;
  model.covariance = egosieve::Covariance::kSquaredExponential;
  model.dimension = 2;
  model.device = options.device;
  egosieve::GaussianProcess gp = egosieve::GaussianProcess::Create(model).value();
  gp.Condition({places, 2}, values).ThrowIfError();
  const egosieve::OptimizeResult found = gp.Optimize().value();
  const egosieve::GaussianProcessInfo info = gp.Describe().value();
  std::printf("%lld wells: log likelihood %.3f, length-scales %.3f and %.3f, noise %.3f\n",
              static_cast<long long>(options.wells), found.log_likelihood, info.scales[0],
              info.scales[1], info.noise_stddev);

  const int64_t side = options.side;
  std::vector<float> mean(side * side), deviation(side * side);
  egosieve::Grid grid{};
  grid.x0 = grid.y0 = -1.0;
  grid.dx = grid.dy = 2.0 / static_cast<double>(side - 1);
  grid.rows = grid.columns = side;
  const auto start = std::chrono::steady_clock::now();
  gp.PredictGrid(grid, {{mean.data(), side, side}, {deviation.data(), side, side}}).value();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  double squares = 0.0;
  for (int64_t r = 0; r < side; ++r) {
    for (int64_t c = 0; c < side; ++c) {
      float& variance = deviation[r * side + c];
      variance = std::sqrt(variance);
      const double error = mean[r * side + c] - Field(grid.x0 + c * grid.dx, grid.y0 + r * grid.dy);
      squares += error * error;
    }
  }
  std::printf("%lld points in %.2f s, error %.4f (root mean square)\n",
              static_cast<long long>(side * side), seconds,
              std::sqrt(squares / static_cast<double>(side * side)));
  if (!options.out.empty() && !Write(options.out, mean, deviation)) {
    std::fprintf(stderr, "%s cannot be written\n", options.out.c_str());
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!Parse(argc, argv, options)) {
    std::fprintf(stderr,
                 "usage: kriging [--wells=N] [--side=PIXELS] [--device=NAME] [--out=FILE]\n");
    return 2;
  }
  try {
    return Krige(options);
  } catch (const egosieve::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
