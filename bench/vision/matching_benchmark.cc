// Matching 7000 features with 7000: full search, OpenCV's full search on the same features, and
// windowed search.
#include <benchmark/benchmark.h>

#include <opencv2/features2d.hpp>
#include <utility>
#include <vector>

#include "bench/vision/textured_pair.h"
#include "vision/features/feature_extractor.h"
#include "vision/matching/feature_matcher.h"

namespace egosieve::vision {
namespace {

struct FeaturePair {
  FeatureSet first, second;
};

// All features of one kind, so that full search compares every feature with every other.
const FeaturePair& Features() {
  static const FeaturePair pair = [] {
    FeaturePair made{*ExtractFeatures(BenchmarkPair().first, {}),
                     *ExtractFeatures(BenchmarkPair().second, {})};
    for (FeatureSet* set : {&made.first, &made.second}) set->key_point_count = set->size();
    return made;
  }();
  return pair;
}

cv::Mat AsFloats(const FeatureSet& set) {
  const cv::Mat bytes(static_cast<int>(set.size()), kSiftDescriptorBytes, CV_8U,
                      const_cast<uint8_t*>(set.descriptor(0)));
  cv::Mat floats;
  bytes.convertTo(floats, CV_32F);
  return floats;
}

std::vector<std::pair<int, int>> OpenCvMatches(const cv::Mat& a, const cv::Mat& b, double ratio) {
  std::vector<std::vector<cv::DMatch>> forward;
  std::vector<cv::DMatch> backward;
  const cv::BFMatcher matcher(cv::NORM_L2);
  matcher.knnMatch(a, b, forward, 2);
  matcher.match(b, a, backward);
  std::vector<std::pair<int, int>> matches;
  for (const auto& two : forward) {
    if (two.size() < 2) continue;
    const bool distinct = two[0].distance < ratio * two[1].distance;
    if (distinct && backward[two[0].trainIdx].trainIdx == two[0].queryIdx) {
      matches.emplace_back(two[0].queryIdx, two[0].trainIdx);
    }
  }
  return matches;
}

double ShareTrue(const std::vector<Match>& matches) {
  int64_t good = 0;
  for (const Match& match : matches) {
    const cv::Point2f p = Features().first.positions[match.first];
    const cv::Vec3d q = BenchmarkPair().homography * cv::Vec3d(p.x, p.y, 1);
    const cv::Point2f found = Features().second.positions[match.second];
    good += std::hypot(q[0] / q[2] - found.x, q[1] / q[2] - found.y) < 2.0;
  }
  return static_cast<double>(good) / static_cast<double>(matches.size());
}

void BM_MatchFull(benchmark::State& state) {
  const FeaturePair& features = Features();
  MatchOptions options;
  options.threads = static_cast<int>(state.range(0));
  absl::StatusOr<std::vector<Match>> matches = absl::UnknownError("");
  for (auto _ : state) matches = MatchFeatures(features.first, features.second, options);
  if (!matches.ok()) return state.SkipWithError(matches.status().ToString().c_str());
  std::vector<std::pair<int, int>> found;
  for (const Match& match : *matches) found.emplace_back(match.first, match.second);
  if (found != OpenCvMatches(AsFloats(features.first), AsFloats(features.second), options.ratio)) {
    return state.SkipWithError("not the matches of exhaustive search");
  }
  const double pairs =
      static_cast<double>(features.first.size()) * static_cast<double>(features.second.size());
  state.counters["matches"] = static_cast<double>(matches->size());
  state.counters["multiply_adds_per_second"] = benchmark::Counter(
      pairs * kSiftDescriptorBytes, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_MatchFull)->ArgName("threads")->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_MatchFullOpenCv(benchmark::State& state) {
  const cv::Mat a = AsFloats(Features().first), b = AsFloats(Features().second);
  for (auto _ : state) benchmark::DoNotOptimize(OpenCvMatches(a, b, 0.8));
}
BENCHMARK(BM_MatchFullOpenCv)->Iterations(1)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_MatchWindowed(benchmark::State& state) {
  const FeaturePair& features = Features();
  MatchOptions options;
  options.threads = static_cast<int>(state.range(0));
  std::vector<cv::Point2f> predicted;
  for (const cv::Point2f& p : features.first.positions) {
    const cv::Vec3d q = BenchmarkPair().homography * cv::Vec3d(p.x, p.y, 1);
    predicted.emplace_back(q[0] / q[2] + 4, q[1] / q[2] - 4);  // a prediction is never exact
  }
  absl::StatusOr<std::vector<Match>> matches = absl::UnknownError("");
  for (auto _ : state) {
    matches = MatchFeaturesNear(features.first, features.second, predicted, options);
  }
  if (!matches.ok()) return state.SkipWithError(matches.status().ToString().c_str());
  const auto full = MatchFeatures(features.first, features.second, options);
  if (matches->size() < full->size()) return state.SkipWithError("fewer matches than full search");
  state.counters["matches"] = static_cast<double>(matches->size());
  state.counters["true_share"] = ShareTrue(*matches);
  state.counters["full_search_matches"] = static_cast<double>(full->size());
  state.counters["full_search_true_share"] = ShareTrue(*full);
}
BENCHMARK(BM_MatchWindowed)
    ->ArgName("threads")
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::vision
