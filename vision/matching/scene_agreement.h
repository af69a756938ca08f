// Decides whether two frames show one scene, by the points found again and their positions.
//
//   areas     8 x 4, judged where they have at least 12 points of a source; if fewer than 6 can
//             be judged, the whole picture is one area
//   holds     a quarter of the textured points of dense flow agree, or 0.08 of the features (0.03
//             in the whole picture) match as their neighbours do                        (SA1)
//   a scene   areas that hold >= 0.35 of those judged                                   (SA2)
//
// Points also agree by chance, above all by flow in smooth pictures. Objects fixed to the camera,
// such as a bonnet or a logo, are found again after a cut, hence the areas. Either source suffices
// for an area, since smooth pictures have few features, and flow is lost where displacements are
// large.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace egosieve::vision {

class SceneAgreement {
 public:
  SceneAgreement() : SceneAgreement(cv::Size(1, 1)) {}
  explicit SceneAgreement(cv::Size size) : size_(size) {}

  // A textured point of the flow's grid, or a feature, in either of the two frames.
  void AddFlow(cv::Point2f place, bool agrees) { Add(place, agrees, flow_); }
  void AddFeature(cv::Point2f place, bool agrees) { Add(place, agrees, features_); }

  struct Areas {
    int judged = 0, holding = 0;
  };
  Areas CountAreas() const;  // (SA1)
  bool IsOneScene() const;   // (SA2)

 private:
  static constexpr int kColumns = 8, kRows = 4;
  struct Votes {
    int64_t all = 0, agreeing = 0;
  };
  using AreaVotes = std::array<Votes, kColumns * kRows>;

  void Add(cv::Point2f place, bool agrees, AreaVotes& areas) const;

  cv::Size size_;
  AreaVotes flow_{}, features_{};
};

}  // namespace egosieve::vision
