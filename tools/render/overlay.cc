#include "tools/render/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

struct Tint {
  cv::Vec3f colour;  // B G R
  float alpha;
};

// Blue, light grey and orange of about equal lightness steps (after ColorBrewer's PuOr).
const std::array<Tint, 5> kAnchors = {{{{172, 102, 33}, 0.22f},
                                       {{207, 169, 103}, 0.16f},
                                       {{235, 235, 235}, 0.10f},
                                       {{77, 163, 253}, 0.45f},
                                       {{13, 85, 230}, 0.65f}}};
constexpr int kTints = 256;

std::array<Tint, kTints> MakeTints() {
  std::array<Tint, kTints> tints;
  for (int i = 0; i < kTints; ++i) {
    const float position = static_cast<float>(i) / (kTints - 1) * (kAnchors.size() - 1);
    const size_t low = std::min(static_cast<size_t>(position), kAnchors.size() - 2);
    const float share = position - static_cast<float>(low);
    const Tint& a = kAnchors[low];
    const Tint& b = kAnchors[low + 1];
    tints[i] = {a.colour * (1 - share) + b.colour * share, a.alpha * (1 - share) + b.alpha * share};
  }
  return tints;
}

const Tint& TintOf(float probability) {
  static const std::array<Tint, kTints>& tints = *new std::array<Tint, kTints>(MakeTints());
  return tints[std::clamp(static_cast<int>(std::lround(probability * (kTints - 1))), 0,
                          kTints - 1)];
}

cv::Mat3b Blend(const cv::Mat3b& frame, const cv::Mat1f& probability) {
  cv::Mat3b blended(frame.size());
  for (int y = 0; y < frame.rows; ++y) {
    for (int x = 0; x < frame.cols; ++x) {
      const Tint& tint = TintOf(probability(y, x));
      const cv::Vec3f colour =
          cv::Vec3f(frame(y, x)) * (1.0f - tint.alpha) + tint.colour * tint.alpha;
      blended(y, x) =
          cv::Vec3b(cv::saturate_cast<uchar>(colour[0]), cv::saturate_cast<uchar>(colour[1]),
                    cv::saturate_cast<uchar>(colour[2]));
    }
  }
  return blended;
}

void DrawContours(const cv::Mat1f& probability, const vision::ObjectThresholds& objects,
                  cv::Mat3b& image) {
  const cv::Mat1b inside =
      vision::NumberObjects(probability >= objects.low, probability >= objects.high) != 0;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(inside, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  const int width = std::max(1, image.cols / 640);
  cv::drawContours(image, contours, -1, cv::Scalar(20, 20, 20), 2 * width + 1, cv::LINE_AA);
  cv::drawContours(image, contours, -1, cv::Scalar(235, 255, 255), width, cv::LINE_AA);
}

// Diagonal lines, continuous over neighbouring areas.
void DrawHatching(const cv::Mat3b& frame, const std::vector<cv::Rect>& areas, cv::Mat3b& picture) {
  constexpr int kPeriod = 12;
  for (const cv::Rect& area : areas) {
    const cv::Rect inside = area & cv::Rect(0, 0, frame.cols, frame.rows);
    for (int y = inside.y; y < inside.y + inside.height; ++y) {
      for (int x = inside.x; x < inside.x + inside.width; ++x) {
        picture(y, x) =
            (x + y) % kPeriod < 2 ? cv::Vec3b(150, 150, 150) : cv::Vec3b(frame(y, x) * 0.8);
      }
    }
  }
}

// Text whose left edge and vertical middle are at `place`; returns its width.
int DrawText(const std::string& text, cv::Point place, double scale, cv::Mat3b& image) {
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &baseline);
  cv::putText(image, text, place + cv::Point(0, size.height / 2), cv::FONT_HERSHEY_SIMPLEX, scale,
              cv::Scalar(235, 235, 235), 1, cv::LINE_AA);
  return size.width;
}

int TextWidth(const std::string& text, double scale) {
  int baseline = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &baseline).width;
}

// static [colours, a tick at each threshold] moving    line: ...             caption
void DrawLegend(const std::string& caption, const vision::ObjectThresholds& objects,
                cv::Mat3b strip) {
  strip.setTo(cv::Scalar(32, 28, 26));
  const int height = strip.rows;
  const double scale = height / 52.0;
  const int gap = height / 3;
  const int middle = height / 2;
  int x = gap + DrawText("static", {gap, middle}, scale, strip) + gap;
  const int bar_width = std::clamp(strip.cols / 6, 40, 240);
  const int bar_height = height / 2;
  for (int i = 0; i < bar_width && x + i < strip.cols; ++i) {
    const Tint& tint = TintOf(static_cast<float>(i) / (bar_width - 1));
    cv::line(strip, {x + i, middle - bar_height / 2}, {x + i, middle + bar_height / 2},
             cv::Scalar(tint.colour[0], tint.colour[1], tint.colour[2]));
  }
  for (const double threshold : {objects.low, objects.high}) {
    const int tick = x + static_cast<int>(std::lround(threshold * (bar_width - 1)));
    cv::line(strip, {tick, middle - bar_height / 2 - 3}, {tick, middle + bar_height / 2 + 3},
             cv::Scalar(20, 20, 20), 3);
    cv::line(strip, {tick, middle - bar_height / 2 - 3}, {tick, middle + bar_height / 2 + 3},
             cv::Scalar(235, 255, 255), 1);
  }
  x += bar_width + gap;
  x += DrawText("moving", {x, middle}, scale, strip) + 3 * gap;
  const std::string rule =
      absl::StrFormat("line: p from %.2f, with %.2f", objects.low, objects.high);
  const int caption_place = strip.cols - TextWidth(caption, scale) - gap;
  if (x + TextWidth(rule, scale) + gap < caption_place) {
    DrawText(rule, {x, middle}, scale, strip);
  }
  if (x < caption_place) {
    DrawText(caption, {caption_place, middle}, scale, strip);
  }
}

}  // namespace

cv::Mat3b DrawOverlay(const cv::Mat3b& frame, const cv::Mat1f& probability,
                      const std::string& caption, const OverlayOptions& options) {
  cv::Mat3b picture = Blend(frame, probability);
  cv::Mat1f drawn = probability.clone();
  for (const cv::Rect& area : options.own_car) {
    drawn(area & cv::Rect(0, 0, drawn.cols, drawn.rows)) = 0.0f;
  }
  DrawContours(drawn, options.objects, picture);
  DrawHatching(frame, options.own_car, picture);
  const int strip_height = options.legend ? std::clamp(frame.rows / 16, 20, 44) : 0;
  const int width = frame.cols + frame.cols % 2;
  const int height = frame.rows + strip_height + (frame.rows + strip_height) % 2;
  cv::Mat3b page(height, width, cv::Vec3b(0, 0, 0));
  picture.copyTo(page(cv::Rect(0, 0, frame.cols, frame.rows)));
  if (options.legend) {
    DrawLegend(caption, options.objects, page(cv::Rect(0, frame.rows, width, height - frame.rows)));
  }
  return page;
}

}  // namespace egosieve::tools
