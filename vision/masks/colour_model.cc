#include "vision/masks/colour_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "kernels/base/parallel_for.h"

namespace egosieve::vision {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr int kParts = 12;
constexpr float kSpread = 8.0f;  // squared steps of Lab
constexpr float kFar = 0.02f;
constexpr double kAroundMovers = 0.1;  // of the picture's longer side
constexpr double kSupportPixels = 200.0;
constexpr int kIterations = 15;
constexpr float kLeastShare = 1e-3f;  // of a part in a colour that changes the part

// The colours in bins of 1 << kBinShift steps per axis.
constexpr int kBinShift = 2;
constexpr size_t kBins = 256 >> kBinShift;

size_t BinOf(const cv::Vec3b& colour) {
  return ((colour[0] >> kBinShift) * kBins + (colour[1] >> kBinShift)) * kBins +
         (colour[2] >> kBinShift);
}

Vector3f MiddleOf(size_t bin) {
  const auto middle = [](size_t step) {
    return (static_cast<float>(step) + 0.5f) * (1 << kBinShift) - 0.5f;
  };
  return {middle(bin / (kBins * kBins)), middle(bin / kBins % kBins), middle(bin % kBins)};
}

struct Colour {
  Vector3f place;
  float weight = 0.0f;
};

// The bins that have weight, with their sums of weights.
std::vector<Colour> Histogram(const std::vector<cv::Mat3b>& colours,
                              const std::vector<cv::Mat1f>& weights) {
  std::vector<double> sums(kBins * kBins * kBins, 0.0);
  for (size_t t = 0; t < colours.size(); ++t) {
    auto weight = weights[t].begin();
    for (const cv::Vec3b& colour : colours[t]) sums[BinOf(colour)] += *weight++;
  }
  std::vector<Colour> histogram;
  for (size_t bin = 0; bin < sums.size(); ++bin) {
    if (sums[bin] > 0.0) histogram.push_back({MiddleOf(bin), static_cast<float>(sums[bin])});
  }
  return histogram;
}

// Weight, mean and covariance of weighted colours.
class Moments {
 public:
  void Add(const Vector3f& place, double weight) {
    const Eigen::Vector3d x = place.cast<double>();
    weight_ += weight;
    first_ += weight * x;
    second_ += weight * x * x.transpose();
  }
  double weight() const { return weight_; }
  Eigen::Vector3d Mean() const { return first_ / std::max(weight_, 1e-9); }
  Eigen::Matrix3d Covariance() const {
    const Eigen::Vector3d mean = Mean();
    return second_ / std::max(weight_, 1e-9) - mean * mean.transpose();
  }

 private:
  double weight_ = 0.0;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_ = Eigen::Matrix3d::Zero();
};

// Parts of the colours: the one that is widest, by weight times greatest variance, is halved at its
// mean across its longest axis, until there are kParts.
std::vector<Moments> SplitColours(const std::vector<Colour>& colours) {
  std::vector<Moments> parts(1);
  std::vector<int> part_of(colours.size(), 0);
  for (const Colour& colour : colours) parts[0].Add(colour.place, colour.weight);
  while (static_cast<int>(parts.size()) < kParts) {
    int widest = 0;
    double width = -1.0;
    Eigen::Vector3d axis;
    for (size_t k = 0; k < parts.size(); ++k) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(parts[k].Covariance());
      if (axes.eigenvalues()(2) * parts[k].weight() <= width) continue;
      width = axes.eigenvalues()(2) * parts[k].weight();
      widest = static_cast<int>(k);
      axis = axes.eigenvectors().col(2);
    }
    const double middle = axis.dot(parts[widest].Mean());
    std::array<Moments, 2> halves;
    for (size_t i = 0; i < colours.size(); ++i) {
      if (part_of[i] != widest) continue;
      const bool is_above = axis.dot(colours[i].place.cast<double>()) > middle;
      halves[is_above ? 1 : 0].Add(colours[i].place, colours[i].weight);
      if (is_above) part_of[i] = static_cast<int>(parts.size());
    }
    parts[widest] = halves[0];
    parts.push_back(halves[1]);
  }
  return parts;
}

// (C1), fitted by expectation maximisation.
class Mixture {
 public:
  explicit Mixture(const std::vector<Colour>& colours) {
    std::vector<Moments> parts = SplitColours(colours);
    double all = 0.0;
    for (const Moments& part : parts) all += part.weight();
    Set(parts, all);
    std::array<float, kParts> shares;
    for (int k = 0; k < kIterations; ++k) {
      std::vector<Moments> next(kParts);
      for (const Colour& colour : colours) {
        Shares(colour.place, shares);
        for (int part = 0; part < kParts; ++part) {
          if (shares[part] < kLeastShare) continue;
          next[part].Add(colour.place, shares[part] * colour.weight);
        }
      }
      Set(next, all);
    }
  }

  float LogDensity(const Vector3f& colour) const {
    std::array<float, kParts> shares;
    return Shares(colour, shares);
  }

 private:
  struct Part {
    Matrix3f whiten;
    Vector3f mean;  // whitened
    float log_scale = 0.0f;
  };

  void Set(const std::vector<Moments>& moments, double all) {
    for (int k = 0; k < kParts; ++k) {
      Eigen::Matrix3d covariance = moments[k].Covariance();
      covariance.diagonal().array() += kSpread;
      const Eigen::Matrix3d lower = covariance.llt().matrixL();
      const Eigen::Matrix3d whiten =
          lower.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
      parts_[k].whiten = whiten.cast<float>();
      parts_[k].mean = (whiten * moments[k].Mean()).cast<float>();
      parts_[k].log_scale = static_cast<float>(
          std::log(std::max(moments[k].weight() / all, 1e-12)) -
          1.5 * std::log(2.0 * std::numbers::pi) - std::log(lower.diagonal().prod()));
    }
  }

  // The share of each part in the density at a colour; returns the density's logarithm.
  float Shares(const Vector3f& colour, std::array<float, kParts>& shares) const {
    float top = -1e30f, sum = 0.0f;
    for (int k = 0; k < kParts; ++k) {
      const Part& part = parts_[k];
      shares[k] = part.log_scale - 0.5f * (part.whiten * colour - part.mean).squaredNorm();
      top = std::max(top, shares[k]);
    }
    for (float& share : shares) {
      share = std::exp(share - top);
      sum += share;
    }
    for (float& share : shares) share /= sum;
    return top + std::log(sum);
  }

  std::array<Part, kParts> parts_;
};

// (C3) of the middle of each bin that the pictures have.
std::vector<float> EvidenceTable(const std::vector<cv::Mat3b>& colours, const Mixture& moving,
                                 const Mixture& still, float known, float limit) {
  std::vector<float> table(kBins * kBins * kBins, 0.0f);
  std::vector<uint8_t> is_seen(table.size(), 0);
  for (const cv::Mat3b& of_picture : colours) {
    for (const cv::Vec3b& colour : of_picture) is_seen[BinOf(colour)] = 1;
  }
  constexpr size_t kSlice = kBins * kBins;
  kernels::ParallelFor(kBins, [&](int64_t slice) {
    for (size_t bin = slice * kSlice; bin < (slice + 1) * kSlice; ++bin) {
      if (is_seen[bin] == 0) continue;
      const Vector3f colour = MiddleOf(bin);
      const float ratio = moving.LogDensity(colour) - still.LogDensity(colour);
      table[bin] = std::clamp(known * ratio, -limit, limit);
    }
  });
  return table;
}

double Sum(const std::vector<cv::Mat1f>& weights) {
  double sum = 0.0;
  for (const cv::Mat1f& of_picture : weights) sum += cv::sum(of_picture)[0];
  return sum;
}

}  // namespace

std::vector<cv::Mat1f> ColourEvidence(const std::vector<cv::Mat3b>& colours,
                                      const std::vector<cv::Mat1f>& probability, float limit) {
  const auto count = static_cast<int64_t>(colours.size());
  std::vector<cv::Mat1f> moving(count), still(count), around(count);
  kernels::ParallelFor(count, [&](int64_t t) {
    const cv::Mat1f &p = probability[t], q = 1.0f - p;
    moving[t] = p.mul(p).mul(p);
    still[t] = q.mul(q).mul(q);
    cv::Mat1f near;
    cv::GaussianBlur(p, near, {}, kAroundMovers * std::max(p.cols, p.rows));
    double most = 0.0;
    cv::minMaxLoc(near, nullptr, &most);
    around[t] = still[t].mul(near + kFar * static_cast<float>(most));
  });
  const double all_moving = Sum(moving), all_still = Sum(still),
               least = std::min(all_moving, all_still);
  const auto known = static_cast<float>(least / (least + kSupportPixels));
  std::vector<cv::Mat1f> evidence(count);
  for (int64_t t = 0; t < count; ++t) evidence[t] = cv::Mat1f::zeros(colours[t].size());
  if (!(least > 0.0)) return evidence;
  std::vector<Mixture> mixtures;
  for (const auto* weights : {&moving, &around})
    mixtures.emplace_back(Histogram(colours, *weights));
  const std::vector<float> table = EvidenceTable(colours, mixtures[0], mixtures[1], known, limit);
  kernels::ParallelFor(count, [&](int64_t t) {
    std::transform(colours[t].begin(), colours[t].end(), evidence[t].begin(),
                   [&](const cv::Vec3b& colour) { return table[BinOf(colour)]; });
  });
  return evidence;
}

}  // namespace egosieve::vision
