#include "tools/render/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

#include "absl/strings/str_cat.h"
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
void DrawHatching(const cv::Mat3b& frame, const cv::Mat1b& ignored, cv::Mat3b& picture) {
  constexpr int kPeriod = 12;
  if (ignored.size() != frame.size()) return;
  for (int y = 0; y < frame.rows; ++y) {
    for (int x = 0; x < frame.cols; ++x) {
      if (ignored(y, x) == 0) continue;
      picture(y, x) =
          (x + y) % kPeriod < 2 ? cv::Vec3b(150, 150, 150) : cv::Vec3b(frame(y, x) * 0.8);
    }
  }
}

// Draws text with its left edge and vertical middle at `place`; returns its width.
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

void DrawCaption(const std::string& caption, double scale, cv::Mat3b& strip, int free_from) {
  const int place = strip.cols - TextWidth(caption, scale) - strip.rows / 3;
  if (free_from < place) DrawText(caption, {place, strip.rows / 2}, scale, strip);
}

// static [colours, a tick at each threshold] moving    line: ...             caption
void DrawLegend(const std::string& caption, const vision::ObjectThresholds& objects,
                cv::Mat3b strip) {
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
  DrawCaption(caption, scale, strip, x);
}

void FillMovers(const cv::Mat1w& ids, cv::Mat3b& picture) {
  constexpr float kAlpha = 0.5f;
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) {
      if (ids(y, x) == 0) continue;
      picture(y, x) = picture(y, x) * (1.0f - kAlpha) + MoverColour(ids(y, x)) * kAlpha;
    }
  }
}

void OutlineMover(const cv::Mat1b& mover, int number, cv::Mat3b& picture) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mover, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  const int width = std::max(1, picture.cols / 640);
  const cv::Vec3b colour = MoverColour(number);
  cv::drawContours(picture, contours, -1, cv::Scalar(20, 20, 20), 2 * width + 1, cv::LINE_AA);
  cv::drawContours(picture, contours, -1, cv::Scalar(colour), width, cv::LINE_AA);
  const std::string text = std::to_string(number);
  const double scale = std::max(0.4, picture.cols / 1600.0);
  const cv::Rect box = cv::boundingRect(mover);
  const cv::Point place(box.x, std::max(box.y - 3, static_cast<int>(25 * scale)));
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(20, 20, 20),
              width + 2, cv::LINE_AA);
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(245, 245, 245),
              width, cv::LINE_AA);
}

// The picture above a strip for the legend, which is returned, too. Both sides are even.
cv::Mat3b MakePage(const cv::Mat3b& picture, bool with_legend, cv::Mat3b* strip) {
  const int strip_height =
      with_legend ? std::clamp(std::min(picture.rows, picture.cols) / 16, 20, 44) : 0;
  const int width = picture.cols + picture.cols % 2;
  const int height = picture.rows + strip_height + (picture.rows + strip_height) % 2;
  cv::Mat3b page(height, width, cv::Vec3b(0, 0, 0));
  picture.copyTo(page(cv::Rect(0, 0, picture.cols, picture.rows)));
  *strip = page(cv::Rect(0, picture.rows, width, height - picture.rows));
  if (with_legend) strip->setTo(cv::Scalar(32, 28, 26));
  return page;
}

}  // namespace

cv::Mat3b DrawOverlay(const cv::Mat3b& frame, const cv::Mat1f& probability,
                      const std::string& caption, const OverlayOptions& options) {
  cv::Mat3b picture = Blend(frame, probability);
  cv::Mat1f drawn = probability.clone();
  if (options.ignored.size() == drawn.size()) drawn.setTo(0.0F, options.ignored);
  DrawContours(drawn, options.objects, picture);
  DrawHatching(frame, options.ignored, picture);
  cv::Mat3b strip;
  cv::Mat3b page = MakePage(picture, options.legend, &strip);
  if (options.legend) DrawLegend(caption, options.objects, strip);
  return page;
}

cv::Vec3b MoverColour(int number) {
  // Paul Tol's "bright" colours without grey, then lighter and darker ones.
  static constexpr std::array<std::array<uchar, 3>, 12> kColours = {{{170, 119, 68},
                                                                     {119, 102, 238},
                                                                     {51, 136, 34},
                                                                     {68, 187, 204},
                                                                     {238, 204, 102},
                                                                     {119, 51, 170},
                                                                     {51, 119, 238},
                                                                     {153, 221, 119},
                                                                     {221, 170, 255},
                                                                     {102, 51, 17},
                                                                     {136, 204, 68},
                                                                     {153, 153, 255}}};
  const auto& [blue, green, red] = kColours[number % kColours.size()];
  return {blue, green, red};
}

cv::Mat3b DrawMovers(const cv::Mat3b& frame, const cv::Mat1w& ids, const std::string& caption,
                     const OverlayOptions& options) {
  cv::Mat3b picture = frame.clone();
  if (!options.outlines_only) FillMovers(ids, picture);
  std::set<uint16_t> numbers(ids.begin(), ids.end());
  numbers.erase(0);
  for (const uint16_t number : numbers) OutlineMover(ids == number, number, picture);
  DrawHatching(frame, options.ignored, picture);
  cv::Mat3b strip;
  cv::Mat3b page = MakePage(picture, options.legend, &strip);
  if (options.legend) {
    const double scale = strip.rows / 52.0;
    const int gap = strip.rows / 3;
    std::string text = absl::StrCat(numbers.size(), " moving");
    const std::string whole = text + ", each with its number";
    if (TextWidth(whole + caption, scale) + 4 * gap < strip.cols) text = whole;
    DrawText(text, {gap, strip.rows / 2}, scale, strip);
    DrawCaption(caption, scale, strip, 2 * gap + TextWidth(text, scale));
  }
  return page;
}

}  // namespace egosieve::tools
