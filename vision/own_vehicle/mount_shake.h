// Pictures of a camera that shakes on its mount, such as a phone on a dashboard, as one that is fixed
// to its vehicle would see them.
//
// The vehicle is in the lowest part of the picture, if anywhere. There each picture is registered with
// the median of all by a rotation in the image and a shift, twice, for the median gets sharper.
// Reference: Evangelidis & Psarakis (2008), enhanced correlation coefficient.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct SteadyPictures {
  std::vector<cv::Mat1f> pictures;
  // Per picture: from a place in the steady picture to the one in the original. The identity where
  // the two cannot be registered.
  std::vector<cv::Matx23f> shakes;
};

// pictures: from SmoothPicture() of fixed_pattern.h, of one size; at least one.
SteadyPictures SteadyOnMount(const std::vector<cv::Mat1f>& pictures);

// `picture` as one that is steady on the vehicle. median: of steady pictures. shake: where the search
// begins, and what it finds.
cv::Mat1f Steady(const cv::Mat1f& median, const cv::Mat1f& picture, cv::Matx23f& shake);

// The place in the steady picture that the shake moves to `place`.
cv::Vec2d Steadied(const cv::Matx23f& shake, const cv::Vec2d& place);

// 255 where any of the shakes puts a place of `mask`, which is of the steady picture.
cv::Mat1b Shaken(const cv::Mat1b& mask, const std::vector<cv::Matx23f>& shakes);

// Share of the lowest part that is not 0; 0 if `mask` is empty.
double ShareOfLowest(const cv::Mat1b& mask);

// The median over the pictures of how far the lowest part is from where most of them have it, pixels.
double TypicalShake(const SteadyPictures& steady);

}  // namespace egosieve::vision
