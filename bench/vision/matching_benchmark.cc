// Matching 7000 features with 7000: full search, and OpenCV's on the same features.
#include <benchmark/benchmark.h>

#include <opencv2/features2d.hpp>
#include <utility>
#include <vector>

#include "bench/vision/textured_pair.h"
#include "vision/paper/feature_extractor.h"
#include "vision/paper/feature_matcher.h"

namespace egosieve::vision {
namespace {

struct FeaturePair {
  FeatureSet first, second;
};

// All features of one kind, so that full search compares every feature with every other.
const FeaturePair& Features() {
  static const FeaturePair pair = [] {
    FeaturePair made{*ExtractFeatures(BenchmarkPair().first, 2),
                     *ExtractFeatures(BenchmarkPair().second, 2)};
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

void BM_MatchFull(benchmark::State& state) {
  const FeaturePair& features = Features();
  const auto threads = static_cast<int>(state.range(0));
  std::vector<Match> matches;
  for (auto _ : state) matches = MatchFeatures(features.first, features.second, threads);
  std::vector<std::pair<int, int>> found;
  for (const Match& match : matches) found.emplace_back(match.first, match.second);
  if (found != OpenCvMatches(AsFloats(features.first), AsFloats(features.second), 0.8)) {
    return state.SkipWithError("not the matches of exhaustive search");
  }
  const double pairs =
      static_cast<double>(features.first.size()) * static_cast<double>(features.second.size());
  state.counters["matches"] = static_cast<double>(matches.size());
  state.counters["multiply_adds_per_second"] = benchmark::Counter(
      pairs * kSiftDescriptorBytes, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_MatchFull)->ArgName("threads")->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_MatchFullOpenCv(benchmark::State& state) {
  const cv::Mat a = AsFloats(Features().first), b = AsFloats(Features().second);
  for (auto _ : state) benchmark::DoNotOptimize(OpenCvMatches(a, b, 0.8));
}
BENCHMARK(BM_MatchFullOpenCv)->Iterations(1)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::vision
