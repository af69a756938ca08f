#include "vision/features/flow_refinement.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr float kOfBrightness = 5.0f, kOfGradient = 10.0f, kOfSmoothness = 20.0f;  // (FR1)
constexpr float kLeastGradient2 = 0.01f;                                           // levels^2
constexpr float kLeastDistance2 = 1e-6f;                                           // pixels^2
constexpr int kSweeps = 5;                                                         // per round
constexpr float kRelaxation = 1.6f;

// A field with a column and a row more on each side.
class Padded {
 public:
  explicit Padded(cv::Size size) : values_(size.height + 2, size.width + 2, 0.0f) {}
  // From -1 to the height or the width.
  float* Row(int y) { return values_.ptr<float>(y + 1) + 1; }
  const float* Row(int y) const { return values_.ptr<float>(y + 1) + 1; }
  void RepeatBorder() {
    const int rows = values_.rows, columns = values_.cols;
    for (int y = 1; y + 1 < rows; ++y) {
      float* row = values_.ptr<float>(y);
      row[0] = row[1];
      row[columns - 1] = row[columns - 2];
    }
    values_.row(1).copyTo(values_.row(0));
    values_.row(rows - 2).copyTo(values_.row(rows - 1));
  }

 private:
  cv::Mat1f values_;
};

// The lines of a pixel: gradients and what is left over at u = 0. The first is of brightness.
struct Lines {
  explicit Lines(cv::Size size) {
    for (int k = 0; k < 3; ++k) {
      x[k].create(size);
      y[k].create(size);
      rest[k].create(size);
    }
  }
  cv::Mat1f x[3], y[3], rest[3];
};

class Refinement {
 public:
  Refinement(const FlowPicture& from, const FlowPicture& to, const cv::Mat2f& flow)
      : size_(flow.size()),
        lines_(size_),
        u_(size_),
        v_(size_),
        across_(size_),
        down_(size_),
        new_u_(size_.width),
        new_v_(size_.width) {
    for (int y = 0; y < size_.height; ++y) {
      const cv::Vec2f* f = flow.ptr<cv::Vec2f>(y);
      float *u = u_.Row(y), *v = v_.Row(y);
      for (int x = 0; x < size_.width; ++x) {
        u[x] = f[x][0];
        v[x] = f[x][1];
      }
    }
    Linearise(from, to, flow);
    for (cv::Mat1f& coefficient : system_) coefficient.create(size_);
    for (int x = 0; x <= size_.width; ++x) relaxation_.push_back(x % 2 == 0 ? kRelaxation : 0.0f);
  }

  void Round() {
    u_.RepeatBorder();
    v_.RepeatBorder();
    Weigh();
    for (int sweep = 0; sweep < 2 * kSweeps; ++sweep) {
      for (int y = 0; y < size_.height; ++y) Solve(y, (sweep + y) % 2);
    }
  }

  void CopyTo(cv::Mat2f& flow) const {
    for (int y = 0; y < size_.height; ++y) {
      const float *u = u_.Row(y), *v = v_.Row(y);
      cv::Vec2f* f = flow.ptr<cv::Vec2f>(y);
      for (int x = 0; x < size_.width; ++x) f[x] = {u[x], v[x]};
    }
  }

 private:
  void Linearise(const FlowPicture& from, const FlowPicture& to, const cv::Mat2f& flow) {
    cv::Mat2f places(size_);
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        places(y, x) = flow(y, x) + cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
      }
    }
    cv::Mat1f warped;
    cv::remap(to.Pixels(), warped, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    Padded mean(size_), change(size_), mean_x(size_), mean_y(size_);
    for (int y = 0; y < size_.height; ++y) {
      const float *a = from.At(0, y), *b = warped.ptr<float>(y);
      float *m = mean.Row(y), *d = change.Row(y);
      for (int x = 0; x < size_.width; ++x) {
        m[x] = 0.5f * (a[x] + b[x]);
        d[x] = b[x] - a[x];
      }
    }
    mean.RepeatBorder();
    change.RepeatBorder();
    const auto derive = [&](const Padded& field, int y, float* along_x, float* along_y) {
      const float *above = field.Row(y - 1), *here = field.Row(y), *below = field.Row(y + 1);
      for (int x = 0; x < size_.width; ++x) {
        along_x[x] = 0.5f * (here[x + 1] - here[x - 1]);
        along_y[x] = 0.5f * (below[x] - above[x]);
      }
    };
    for (int y = 0; y < size_.height; ++y) derive(mean, y, mean_x.Row(y), mean_y.Row(y));
    mean_x.RepeatBorder();
    mean_y.RepeatBorder();
    for (int y = 0; y < size_.height; ++y) {
      std::copy_n(mean_x.Row(y), size_.width, lines_.x[0].ptr<float>(y));
      std::copy_n(mean_y.Row(y), size_.width, lines_.y[0].ptr<float>(y));
      std::copy_n(change.Row(y), size_.width, lines_.rest[0].ptr<float>(y));
      derive(mean_x, y, lines_.x[1].ptr<float>(y), lines_.y[1].ptr<float>(y));
      derive(mean_y, y, lines_.x[2].ptr<float>(y), lines_.y[2].ptr<float>(y));
      derive(change, y, lines_.rest[1].ptr<float>(y), lines_.rest[2].ptr<float>(y));
      const float *u = u_.Row(y), *v = v_.Row(y);
      for (int k = 0; k < 3; ++k) {
        float *gx = lines_.x[k].ptr<float>(y), *gy = lines_.y[k].ptr<float>(y);
        float* rest = lines_.rest[k].ptr<float>(y);
        for (int x = 0; x < size_.width; ++x) {
          const float scale = 1.0f / std::sqrt(gx[x] * gx[x] + gy[x] * gy[x] + kLeastGradient2);
          gx[x] *= scale;
          gy[x] *= scale;
          rest[x] = rest[x] * scale - gx[x] * u[x] - gy[x] * v[x];
        }
      }
    }
  }

  // Weights by the lengths at the present u.
  void Weigh() {
    for (int y = 0; y < size_.height; ++y) {
      const float *x0 = lines_.x[0].ptr<float>(y), *x1 = lines_.x[1].ptr<float>(y),
                  *x2 = lines_.x[2].ptr<float>(y);
      const float *y0 = lines_.y[0].ptr<float>(y), *y1 = lines_.y[1].ptr<float>(y),
                  *y2 = lines_.y[2].ptr<float>(y);
      const float *rest0 = lines_.rest[0].ptr<float>(y), *rest1 = lines_.rest[1].ptr<float>(y),
                  *rest2 = lines_.rest[2].ptr<float>(y);
      const float *u = u_.Row(y), *v = v_.Row(y), *u_below = u_.Row(y + 1),
                  *v_below = v_.Row(y + 1);
      float *xx = system_[0].ptr<float>(y), *xy = system_[1].ptr<float>(y),
            *yy = system_[2].ptr<float>(y), *right_x = system_[3].ptr<float>(y),
            *right_y = system_[4].ptr<float>(y);
      float *across = across_.Row(y), *down = down_.Row(y);
#pragma GCC ivdep
      for (int x = 0; x < size_.width; ++x) {
        const float r0 = x0[x] * u[x] + y0[x] * v[x] + rest0[x];
        const float r1 = x1[x] * u[x] + y1[x] * v[x] + rest1[x];
        const float r2 = x2[x] * u[x] + y2[x] * v[x] + rest2[x];
        const float a = kOfBrightness / std::sqrt(r0 * r0 + kLeastDistance2);
        const float b = kOfGradient / std::sqrt(r1 * r1 + r2 * r2 + kLeastDistance2);
        xx[x] = a * x0[x] * x0[x] + b * (x1[x] * x1[x] + x2[x] * x2[x]);
        xy[x] = a * x0[x] * y0[x] + b * (x1[x] * y1[x] + x2[x] * y2[x]);
        yy[x] = a * y0[x] * y0[x] + b * (y1[x] * y1[x] + y2[x] * y2[x]);
        right_x[x] = -(a * x0[x] * rest0[x] + b * (x1[x] * rest1[x] + x2[x] * rest2[x]));
        right_y[x] = -(a * y0[x] * rest0[x] + b * (y1[x] * rest1[x] + y2[x] * rest2[x]));
        const float ux = u[x + 1] - u[x], uy = u_below[x] - u[x];
        const float vx = v[x + 1] - v[x], vy = v_below[x] - v[x];
        across[x] = down[x] =
            kOfSmoothness / std::sqrt(ux * ux + uy * uy + vx * vx + vy * vy + kLeastDistance2);
      }
      across[size_.width - 1] = 0.0f;  // nothing beyond the border
    }
    std::fill_n(down_.Row(size_.height - 1), size_.width, 0.0f);
  }

  // The row's pixels of one colour of the chequerboard, each from its neighbours, which are of the
  // other. All are computed, for vectors, and the others keep their values. GCC makes no vectors of
  // a loop that writes what its next turn reads, so the values are written beside first.
  void Solve(int y, int colour) {
    const float *xx = system_[0].ptr<float>(y), *xy = system_[1].ptr<float>(y),
                *yy = system_[2].ptr<float>(y), *right_x = system_[3].ptr<float>(y),
                *right_y = system_[4].ptr<float>(y);
    const float *across = across_.Row(y), *down = down_.Row(y), *up = down_.Row(y - 1);
    const float *u_above = u_.Row(y - 1), *u_below = u_.Row(y + 1);
    const float *v_above = v_.Row(y - 1), *v_below = v_.Row(y + 1);
    const float* relaxation = relaxation_.data() + colour;
    float *u = u_.Row(y), *v = v_.Row(y), *new_u = new_u_.data(), *new_v = new_v_.data();
#pragma GCC ivdep
    for (int x = 0; x < size_.width; ++x) {
      const float before = across[x - 1], after = across[x], above = up[x], below = down[x];
      const float links = before + after + above + below;
      const float p = right_x[x] + before * u[x - 1] + after * u[x + 1] + above * u_above[x] +
                      below * u_below[x];
      const float q = right_y[x] + before * v[x - 1] + after * v[x + 1] + above * v_above[x] +
                      below * v_below[x];
      const float a = xx[x] + links, b = xy[x], c = yy[x] + links;
      const float scale = relaxation[x] / (a * c - b * b);
      const float keep = 1.0f - relaxation[x];
      new_u[x] = keep * u[x] + scale * (c * p - b * q);
      new_v[x] = keep * v[x] + scale * (a * q - b * p);
    }
    std::ranges::copy(new_u_, u);
    std::ranges::copy(new_v_, v);
  }

  const cv::Size size_;
  Lines lines_;
  Padded u_, v_;
  Padded across_, down_;              // weights of the links to the right and down
  cv::Mat1f system_[5];               // xx, xy, yy, and the right side
  std::vector<float> new_u_, new_v_;  // of a row
  std::vector<float> relaxation_;     // kRelaxation and 0 in turn
};

}  // namespace

void RefineFlow(const FlowPicture& from, const FlowPicture& to, int rounds, cv::Mat2f& flow) {
  if (rounds == 0) return;
  Refinement refinement(from, to, flow);
  for (int round = 0; round < rounds; ++round) refinement.Round();
  refinement.CopyTo(flow);
}

}  // namespace egosieve::vision
