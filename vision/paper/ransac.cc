#include "vision/paper/ransac.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "absl/strings/str_cat.h"
#include "vision/geometry/mix_seed.h"
#include "vision/paper/ransac_model.h"

namespace egosieve::vision {
namespace {

// Our own random numbers, so that a seed draws the same samples with every standard library.
class Sampler {
 public:
  explicit Sampler(uint64_t seed) : engine_(seed) {}

  // Uniform in [0, bound); bound > 0. The bias of the multiply-and-shift is below bound / 2^32.
  int64_t Below(int64_t bound) {
    return static_cast<int64_t>((engine_() >> 32) * static_cast<uint64_t>(bound) >> 32);
  }

  // `count` different indices below `bound`, count <= bound.
  template <size_t count>
  void Distinct(int64_t bound, int64_t (&indices)[count]) {
    for (size_t i = 0; i < count; ++i) {
      do {
        indices[i] = Below(bound);
      } while (std::find(indices, indices + i, indices[i]) != indices + i);
    }
  }

  template <typename T>
  void Shuffle(std::vector<T>& values) {
    for (int64_t i = static_cast<int64_t>(values.size()) - 1; i > 0; --i) {
      std::swap(values[i], values[Below(i + 1)]);
    }
  }

 private:
  std::mt19937_64 engine_;
};

constexpr int64_t kTrialPairs = 400;   // on which a model is tested first
constexpr double kTrialMargin = 1.15;  // models this much worse than the best there are dropped
constexpr int kMaxRefusedPerSample = 20;
constexpr double kConfidence = 0.9999;
constexpr int kMaxIterations = 2000;
constexpr double kSpacingPixels = 2.0;  // between points of a sample, in both images
constexpr int64_t kMaxPairs = 4000;     // of more pairs, this many are drawn at random

// The number of iterations by (RS2).
int RequiredIterations(double inlier_share, int sample_size, double confidence, int maximum) {
  const double all_inliers = std::pow(inlier_share, sample_size);
  if (!(all_inliers > 0.0)) return maximum;
  if (all_inliers >= 1.0) return 1;
  const double required = std::log(1.0 - confidence) / std::log1p(-all_inliers);
  return required < maximum ? std::max(1, static_cast<int>(std::ceil(required))) : maximum;
}

template <int count>
bool IsSpaced(const NormalizedPairs& pairs, const int64_t (&sample)[count], double spacing) {
  const float squared = static_cast<float>(spacing * spacing);
  const auto close = [squared](float dx, float dy) { return !(dx * dx + dy * dy >= squared); };
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < i; ++j) {
      const int64_t a = sample[i], b = sample[j];
      if (close(pairs.x1[a] - pairs.x1[b], pairs.y1[a] - pairs.y1[b])) return false;
      if (close(pairs.x2[a] - pairs.x2[b], pairs.y2[a] - pairs.y2[b])) return false;
    }
  }
  return true;
}

template <typename Model>
class Search {
 public:
  Search(const NormalizedPairs& pairs, const RansacOptions& options)
      : pairs_(pairs),
        threshold_(options.threshold_pixels / pairs.scale_pixels),
        spacing_(kSpacingPixels / pairs.scale_pixels),
        sampler_(options.seed) {}

  // False if no sample gave a model.
  bool Run() {
    int required = kMaxIterations;
    int64_t refused = 0;
    const int64_t most_refused = int64_t{kMaxRefusedPerSample} * kMaxIterations;
    std::vector<Eigen::Matrix3d> models;
    while (iterations_ < required && refused < most_refused) {
      int64_t sample[Model::kSampleSize];
      sampler_.Distinct(pairs_.size(), sample);
      models.clear();
      if (IsSpaced(pairs_, sample, spacing_)) Model::Solve(pairs_, sample, models);
      if (models.empty()) {
        ++refused;
        // Degenerate input: stop after as many rejected samples as models would be tried.
        if (!found_ && refused >= kMaxIterations) break;
        continue;
      }
      ++iterations_;
      for (const Eigen::Matrix3d& model : models) Try(model);
      const double share =
          static_cast<double>(best_.inlier_count) / static_cast<double>(pairs_.size());
      required = RequiredIterations(share, Model::kSampleSize, kConfidence, kMaxIterations);
    }
    if (found_) Optimize(best_model_, best_, kFinalRadii);
    return found_;
  }

  const Eigen::Matrix3d& model() const { return best_model_; }
  const Score& score() const { return best_; }
  int iterations() const { return iterations_; }

 private:
  static constexpr double kRadii[] = {3.0, 2.0, 1.5};
  static constexpr double kFinalRadii[] = {3.0, 3.0, 2.0, 2.0, 1.5, 1.5, 1.5};

  Score Evaluate(const Eigen::Matrix3d& model) const {
    return Model::Evaluate(model, pairs_, 0, pairs_.size(), threshold_);
  }

  void Try(const Eigen::Matrix3d& model) {
    const int64_t trial = std::min(kTrialPairs, pairs_.size());
    Score score = Model::Evaluate(model, pairs_, 0, trial, threshold_);
    if (found_ && !(score.cost < kTrialMargin * best_trial_cost_)) return;
    const Score rest = Model::Evaluate(model, pairs_, trial, pairs_.size(), threshold_);
    score.cost += rest.cost;
    score.inlier_count += rest.inlier_count;
    if (found_ && !(score.cost < best_.cost)) return;
    Eigen::Matrix3d optimized = model;
    Optimize(optimized, score, kRadii);
    best_model_ = optimized;
    best_ = score;
    best_trial_cost_ = Model::Evaluate(best_model_, pairs_, 0, trial, threshold_).cost;
    found_ = true;
  }

  template <size_t count>
  void Optimize(Eigen::Matrix3d& model, Score& score, const double (&radii)[count]) const {
    Eigen::Matrix3d candidate = model;
    for (const double radius : radii) {
      if (!Model::Refine(pairs_, radius * threshold_, candidate)) return;
      const Score next = Evaluate(candidate);
      if (next.cost < score.cost) {
        model = candidate;
        score = next;
      }
    }
  }

  const NormalizedPairs& pairs_;
  const double threshold_, spacing_;
  Sampler sampler_;
  bool found_ = false;
  Eigen::Matrix3d best_model_ = Eigen::Matrix3d::Identity();
  Score best_;
  double best_trial_cost_ = 0.0;
  int iterations_ = 0;
};

template <typename Model>
absl::StatusOr<RansacResult> Estimate(const std::vector<PointPair>& pairs,
                                      const RansacOptions& options, const char* name,
                                      Eigen::Matrix3d (*in_pixels)(const Eigen::Matrix3d&,
                                                                   const NormalizedPairs&)) {
  if (pairs.size() < Model::kSampleSize) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", pairs.size(), " point pairs, ",
                                                   Model::kSampleSize, " are needed"));
  }
  std::vector<int64_t> order(pairs.size());
  std::iota(order.begin(), order.end(), int64_t{0});
  Sampler(MixSeed(options.seed, 0, 0)).Shuffle(order);
  if (static_cast<int64_t>(order.size()) > kMaxPairs) order.resize(kMaxPairs);
  const NormalizedPairs normalized = Normalize(pairs, order);

  Search<Model> search(normalized, options);
  if (!search.Run()) {
    return absl::NotFoundError(
        absl::StrCat(name, ": every sample of the ", pairs.size(), " point pairs is degenerate"));
  }
  RansacResult result;
  result.matrix = in_pixels(search.model(), normalized);
  result.inlier_count = search.score().inlier_count;
  result.iterations = search.iterations();
  return result;
}

}  // namespace

absl::StatusOr<RansacResult> EstimateFundamental(const std::vector<PointPair>& pairs,
                                                 const RansacOptions& options) {
  return Estimate<FundamentalModel>(pairs, options, "fundamental matrix", FundamentalInPixels);
}

absl::StatusOr<RansacResult> EstimateHomography(const std::vector<PointPair>& pairs,
                                                const RansacOptions& options) {
  return Estimate<HomographyModel>(pairs, options, "homography", HomographyInPixels);
}

}  // namespace egosieve::vision
