#include "vision/masks/shot_segmentation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "kernels/base/parallel_for.h"
#include "vision/masks/edge_refinement.h"
#include "vision/masks/tonal_range.h"

namespace egosieve::vision {
namespace {

constexpr int kLongestSide = 432;
constexpr double kMostOfMap = 6.0;
constexpr float kMostDecided = 2.0f, kLeastDecided = 0.01f;
constexpr int kRounds = 2;
constexpr float kLeastLink = 0.05f;  // of links between pictures

// A picture at the size of the graph.
struct Nodes {
  cv::Mat3b lab;
  cv::Mat1f log_odds;
  cv::Mat2f backward;  // nodes
  cv::Mat1f agreement;
};

// is_first: no picture is before it.
Nodes NodesOf(const LinkFrame& frame, const TonalRange& range, bool is_first) {
  const cv::Size size = frame.image.size();
  const int step = (std::max(size.width, size.height) + kLongestSide - 1) / kLongestSide;
  Nodes nodes;
  cv::cvtColor(Stretched(ToWorkingSize(frame.image, step), range), nodes.lab, cv::COLOR_BGR2Lab);
  nodes.log_odds = ToWorkingSize(frame.log_odds, step);
  nodes.log_odds = cv::max(cv::min(nodes.log_odds, kMostOfMap), -kMostOfMap);
  if (is_first) return nodes;
  nodes.backward = ToWorkingSize(frame.flow.backward, step) / step;
  nodes.agreement = ToWorkingSize(AgreementOf(frame.errors.backward, kTolerancePixels), step);
  return nodes;
}

// work(x, y, other): each pair of neighbours in a picture.
template <typename Work>
void ForEachNeighbours(cv::Size size, const Work& work) {
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (x + 1 < size.width) work(x, y, cv::Point(x + 1, y));
      if (y + 1 < size.height) work(x, y, cv::Point(x, y + 1));
    }
  }
}

// 2 m of (SS2).
double ContrastScale(const std::vector<Nodes>& shot) {
  double sum = 0.0, count = 0.0;
  for (const Nodes& nodes : shot) {
    ForEachNeighbours(nodes.lab.size(), [&](int x, int y, cv::Point other) {
      sum += SquaredDifference(nodes.lab(y, x), nodes.lab(other));
      count += 1.0;
    });
  }
  return std::max(2.0 * sum / std::max(count, 1.0), 1e-3);
}

// Mean of |x| over the pictures.
float MeanSize(const std::vector<cv::Mat1f>& pictures) {
  double sum = 0.0, count = 0.0;
  for (const cv::Mat1f& picture : pictures) {
    sum += cv::norm(picture, cv::NORM_L1);
    count += static_cast<double>(picture.total());
  }
  return static_cast<float>(sum / std::max(count, 1.0));
}

// S that minimises (SS2), 0 or 1; unary: u.
std::vector<cv::Mat1f> Cut(const std::vector<Nodes>& shot, const std::vector<cv::Mat1f>& unary,
                           double contrast_scale, const ShotSegmentationOptions& options) {
  const cv::Size size = shot[0].lab.size();
  const auto count = static_cast<unsigned>(shot.size() * size.area());
  cv::detail::GCGraph<float> graph(count, 6 * count);
  for (const cv::Mat1f& of_picture : unary) {
    for (const float u : of_picture) {
      graph.addTermWeights(graph.addVtx(), std::max(u, 0.0f), std::max(-u, 0.0f));
    }
  }
  const auto node = [&](size_t t, int x, int y) {
    return static_cast<int>(t) * size.area() + y * size.width + x;
  };
  const auto scale = static_cast<float>(contrast_scale);
  for (size_t t = 0; t < shot.size(); ++t) {
    const Nodes& nodes = shot[t];
    ForEachNeighbours(size, [&](int x, int y, cv::Point other) {
      const float weight =
          options.within * std::exp(-SquaredDifference(nodes.lab(y, x), nodes.lab(other)) / scale);
      graph.addEdges(node(t, x, y), node(t, other.x, other.y), weight, weight);
    });
    if (t == 0) continue;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const cv::Point there(cvRound(x + nodes.backward(y, x)[0]),
                              cvRound(y + nodes.backward(y, x)[1]));
        const float agreement = nodes.agreement(y, x);
        if (!(agreement > kLeastLink) || !cv::Rect({}, size).contains(there)) continue;
        graph.addEdges(node(t, x, y), node(t - 1, there.x, there.y), options.along * agreement,
                       options.along * agreement);
      }
    }
  }
  graph.maxFlow();
  std::vector<cv::Mat1f> moving;
  for (size_t t = 0; t < shot.size(); ++t) {
    cv::Mat1f& of_picture = moving.emplace_back(size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        of_picture(y, x) = graph.inSourceSegment(node(t, x, y)) ? 1.0f : 0.0f;
      }
    }
  }
  return moving;
}

}  // namespace

std::vector<cv::Mat1f> SegmentShot(const std::vector<LinkFrame>& frames,
                                   const ShotSegmentationOptions& options) {
  const auto count = static_cast<int64_t>(frames.size());
  std::vector<cv::Mat3b> pictures;
  for (const LinkFrame& frame : frames) pictures.push_back(frame.image);
  const TonalRange range = TonalRangeOf(pictures);
  std::vector<Nodes> shot(count);
  kernels::ParallelFor(count, [&](int64_t t) { shot[t] = NodesOf(frames[t], range, t == 0); });
  std::vector<cv::Mat3b> colours;
  std::vector<cv::Mat1f> probability, decided;  // decided: u, then l
  for (const Nodes& nodes : shot) {
    colours.push_back(nodes.lab);
    probability.push_back(Probability(nodes.log_odds));
  }
  const double contrast_scale = ContrastScale(shot);
  for (int round = 0; round < kRounds; ++round) {
    decided = ColourEvidence(colours, probability, options.colour_limit);
    for (int64_t t = 0; t < count; ++t) decided[t] += shot[t].log_odds;
    const float step = std::min(kMostDecided, MeanSize(decided));
    if (step < kLeastDecided) break;
    const std::vector<cv::Mat1f> moving = Cut(shot, decided, contrast_scale, options);
    for (int64_t t = 0; t < count; ++t) {
      decided[t] += step * (2.0f * moving[t] - 1.0f);
      probability[t] = 0.5f * (probability[t] + moving[t]);
    }
  }
  std::vector<cv::Mat1f> joined(count);
  kernels::ParallelFor(count, [&](int64_t t) {
    cv::resize(decided[t], joined[t], frames[t].image.size(), 0, 0, cv::INTER_LINEAR);
  });
  return joined;
}

}  // namespace egosieve::vision
