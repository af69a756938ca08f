#include "tests/vision/labelling/street_drive.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "tests/testing/status.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

constexpr int kOutline = 5;  // pixels, of the square that widens and narrows masks

DrivePicture PictureOf(const SyntheticFrame& frame) {
  DrivePicture picture;
  picture.frame.index = frame.index;
  picture.frame.time_seconds = frame.seconds;
  picture.frame.image = frame.image;
  picture.movers = frame.mask;
  return picture;
}

// How far the point at pixel (x, y) of the frame gets by `later` seconds, pixels.
cv::Point2f MovedBy(const Scenario& scenario, const SyntheticFrame& frame, const Pose& pose, int x,
                    int y, double later) {
  const Intrinsics& k = scenario.intrinsics();
  const double depth = std::min(frame.depth.at<double>(y, x), 1e5);  // the sky is far
  const Eigen::Vector3d ray((x - k.centre_x) / k.focal_pixels, (y - k.centre_y) / k.focal_pixels,
                            1.0);
  Eigen::Vector3d place = frame.pose.rotation * (depth * ray) + frame.pose.centre;
  const int id = frame.ids.at<uint16_t>(y, x);
  for (const ObjectState& object : frame.objects) {
    if (id != 0 && object.id == id) place += later * object.velocity;
  }
  const Eigen::Vector3d seen = pose.rotation.transpose() * (place - pose.centre);
  return {static_cast<float>(k.focal_pixels * seen(0) / seen(2) + k.centre_x - x),
          static_cast<float>(k.focal_pixels * seen(1) / seen(2) + k.centre_y - y)};
}

}  // namespace

Scenario EditedScenario(const std::string& name, uint64_t seed,
                        const std::function<void(Scene&)>& edit) {
  const ScenarioOptions options{.width_pixels = 400, .height_pixels = 240, .threads = 1};
  auto scenario = Value(MakeScenario(name, seed, options));
  Scene scene = scenario.scene();
  edit(scene);
  return Scenario(name, seed, options, std::move(scene));
}

double FocalRatioOf(const Scenario& scenario) {
  return scenario.intrinsics().focal_pixels / scenario.options().width_pixels;
}

TravelPrior TravelOf(const Scenario& scenario, int first) {
  const Pose from = scenario.PoseAt(first), to = scenario.PoseAt(first + 1);
  return {(from.rotation.transpose() * (from.centre - to.centre)).normalized(), 400.0,
          1.0 - TravelPrior::kVehicleTravelsElsewhere};
}

std::vector<DrivePicture> PicturesOf(const Scenario& scenario, int first, int count) {
  std::vector<DrivePicture> pictures;
  for (int t = first; t < first + count; ++t) pictures.push_back(PictureOf(*scenario.Render(t)));
  return pictures;
}

std::vector<DrivePicture> RollingPicturesOf(const Scenario& scenario, int first, int count,
                                            double readout_seconds) {
  std::vector<DrivePicture> pictures;
  for (int t = first; t < first + count; ++t) {
    const SyntheticFrame frame = *scenario.Render(t);
    DrivePicture picture = PictureOf(frame);
    cv::Mat source(frame.image.size(), CV_32FC2);
    for (int y = 0; y < source.rows; ++y) {
      const double later = readout_seconds * ((y + 0.5) / source.rows - 0.5);
      const Pose pose = scenario.scene().camera.At(frame.seconds + later);
      for (int x = 0; x < source.cols; ++x) {
        cv::Point2f from(x, y);
        for (int k = 0; k < 3; ++k) {
          const int column = std::clamp(cvRound(from.x), 0, source.cols - 1);
          const int row = std::clamp(cvRound(from.y), 0, source.rows - 1);
          from = cv::Point2f(x, y) - MovedBy(scenario, frame, pose, column, row, later);
        }
        source.at<cv::Point2f>(y, x) = from;
      }
    }
    cv::Mat image, movers;
    cv::remap(frame.image, image, source, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    cv::remap(frame.mask, movers, source, cv::noArray(), cv::INTER_NEAREST, cv::BORDER_REPLICATE);
    picture.frame.image = image;
    picture.movers = movers;
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

void LabelCounts::Add(const LabelCounts& other) {
  standing += other.standing;
  false_alarms += other.false_alarms;
  moving += other.moving;
  found += other.found;
}

double LabelCounts::FalseShare() const {
  return static_cast<double>(false_alarms) / static_cast<double>(std::max<int64_t>(standing, 1));
}

double LabelCounts::FoundShare() const {
  return static_cast<double>(found) / static_cast<double>(std::max<int64_t>(moving, 1));
}

LabelCounts Count(const LabelledFrame& labels, const cv::Mat& movers) {
  const cv::Mat square = cv::Mat::ones(kOutline, kOutline, CV_8UC1);
  cv::Mat wide, narrow;
  cv::dilate(movers, wide, square);
  cv::erode(movers, narrow, square);
  LabelCounts counts;
  for (int64_t i = 0; i < labels.size(); ++i) {
    const int x = cvRound(labels.positions[2 * i]), y = cvRound(labels.positions[2 * i + 1]);
    const int dynamic = labels.probability[i] > 0.5 ? 1 : 0;
    if (wide.at<uchar>(y, x) == 0) {
      ++counts.standing;
      counts.false_alarms += dynamic;
    } else if (narrow.at<uchar>(y, x) != 0) {
      ++counts.moving;
      counts.found += dynamic;
    }
  }
  return counts;
}

LabelledFrame LastLabels(const FrameLabellerOptions& options,
                         const std::vector<DrivePicture>& pictures) {
  const auto labeller = Value(MakeFrameLabeller(options));
  LabelledFrame labels;
  for (const DrivePicture& picture : pictures) labels = Value(labeller->Process(picture.frame));
  return labels;
}

}  // namespace egosieve::vision
