// A node of ROS 2: pictures of a moving camera in, masks and boxes of what moves by itself out.
//
//   image        in   sensor_msgs/Image of mono8, bgr8 or rgb8
//   camera_info  in   sensor_msgs/CameraInfo: the focal length, which is learnt where none comes
//   mask         out  sensor_msgs/Image, mono8: 255 where the probability of moving is `threshold` or more
//   objects      out  vision_msgs/Detection2DArray: boxes in pixels; the id is the number within the
//                     picture, the score the mean probability
//
// The newest picture comes first: while one is segmented, a later one replaces the one that waits,
// which is dropped. Outputs have the header of their picture. Once a second the log tells pictures,
// drops and the latency from a picture's arrival to its mask.
//
// Parameters: profile ("fast" or "default"), device, threshold, camera_info_seconds (how long the
// first picture waits for the focal length).
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "egosieve/segmenter.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"
#include "vision_msgs/msg/detection2_d_array.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using sensor_msgs::msg::CameraInfo;
using vision_msgs::msg::Detection2DArray;
using Picture = sensor_msgs::msg::Image;

const std::map<std::string, egosieve_channels> kEncodings = {
    {"mono8", EGOSIEVE_GREY}, {"bgr8", EGOSIEVE_BGR}, {"rgb8", EGOSIEVE_RGB}};

struct Box {
  int left = 0, top = 0, right = 0, bottom = 0, area = 0;
  double probability = 0.0;  // sum over the pixels
};

class SegmenterNode : public rclcpp::Node {
 public:
  SegmenterNode() : Node("egosieve") {
    const auto profile = declare_parameter<std::string>("profile", "fast");
    if (profile != "fast" && profile != "default") {
      throw std::invalid_argument("profile is '" + profile + "'; it must be fast or default");
    }
    options_.profile = profile == "fast" ? egosieve::Profile::kFast : egosieve::Profile::kDefault;
    options_.device = declare_parameter<std::string>("device", "");
    threshold_ = declare_parameter<double>("threshold", 0.5);
    lens_wait_ = declare_parameter<double>("camera_info_seconds", 1.0);
    mask_ = create_publisher<Picture>("mask", 1);
    objects_ = create_publisher<Detection2DArray>("objects", 1);
    const auto newest = rclcpp::SensorDataQoS().keep_last(1);
    pictures_ = create_subscription<Picture>(
        "image", newest, [this](Picture::ConstSharedPtr picture) { Take(std::move(picture)); });
    lenses_ = create_subscription<CameraInfo>(
        "camera_info", newest, [this](CameraInfo::ConstSharedPtr lens) { Take(*lens); });
    timer_ = create_wall_timer(std::chrono::seconds(1), [this] { Tell(); });
    worker_ = std::thread([this] { Work(); });
  }

  ~SegmenterNode() override {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    changed_.notify_all();
    worker_.join();
    Tell();
  }

 private:
  void Take(Picture::ConstSharedPtr picture) {
    const std::lock_guard lock(mutex_);
    ++taken_;
    dropped_ += waiting_ != nullptr;
    waiting_ = std::move(picture);
    arrived_ = Clock::now();
    changed_.notify_all();
  }

  void Take(const CameraInfo& lens) {
    const std::lock_guard lock(mutex_);
    if (lens.k[0] > 0.0) {
      focal_ratio_ = 0.5 * (lens.k[0] + lens.k[4]) / std::max(lens.width, lens.height);
    }
    changed_.notify_all();
  }

  // On a thread of its own, so that pictures arrive while one is segmented.
  void Work() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ends_ || waiting_ != nullptr; });
    changed_.wait_for(lock, std::chrono::duration<double>(lens_wait_),
                      [this] { return ends_ || focal_ratio_ > 0.0; });
    options_.focal_ratio = focal_ratio_;
    while (true) {
      changed_.wait(lock, [this] { return ends_ || waiting_ != nullptr; });
      if (ends_) return;
      const Picture::ConstSharedPtr picture = std::exchange(waiting_, nullptr);
      const Clock::time_point arrived = arrived_;
      lock.unlock();
      const bool is_done = Segment(*picture);
      lock.lock();
      if (!is_done) continue;
      const std::chrono::duration<double, std::milli> latency = Clock::now() - arrived;
      latencies_.push_back(latency.count());
    }
  }

  // Publishes the picture's mask and objects; false, and says why, where it has none.
  bool Segment(const Picture& picture) {
    const auto encoding = kEncodings.find(picture.encoding);
    const int width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
    const size_t bytes = static_cast<size_t>(picture.step) * picture.height;
    if (encoding == kEncodings.end() || picture.data.size() < bytes) {
      RCLCPP_ERROR(get_logger(),
                   "picture of %s left out: it is not mono8, bgr8 or rgb8, or cut off",
                   picture.encoding.c_str());
      return false;
    }
    if (!segmenter_) {
      egosieve::Result<egosieve::Segmenter> made = egosieve::Segmenter::Create(options_);
      if (!made.ok()) return Refuse(made.status());
      segmenter_ = std::move(made).value();
    }
    probability_.resize(static_cast<size_t>(width) * height);
    numbers_.resize(probability_.size());
    egosieve::Map map;
    map.probability = {probability_.data(), height, width};
    map.objects = {numbers_.data(), height, width};
    const rclcpp::Time time(picture.header.stamp);
    const auto report = segmenter_->Process(
        {picture.data.data(), width, height, encoding->second, picture.step}, time.seconds(), map);
    if (!report.ok()) return Refuse(report.status());
    // Nothing was learnt yet: the map is the prior.
    if (report->model_size == 0) std::fill(probability_.begin(), probability_.end(), 0.0f);
    PublishMask(picture);
    PublishObjects(picture);
    return true;
  }

  bool Refuse(const egosieve::Status& status) {
    RCLCPP_ERROR(get_logger(), "picture left out: %s", status.message().c_str());
    return false;
  }

  void PublishMask(const Picture& picture) {
    Picture mask;
    mask.header = picture.header;
    mask.width = mask.step = picture.width;
    mask.height = picture.height;
    mask.encoding = "mono8";
    mask.data.resize(probability_.size());
    std::transform(probability_.begin(), probability_.end(), mask.data.begin(),
                   [this](float p) { return p >= threshold_ ? 255 : 0; });
    mask_->publish(mask);
  }

  void PublishObjects(const Picture& picture) {
    const int width = static_cast<int>(picture.width);
    std::map<int, Box> boxes;
    for (size_t i = 0; i < numbers_.size(); ++i) {
      const int number = static_cast<int>(numbers_[i]);
      if (number == 0) continue;
      const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
      Box& box = boxes.try_emplace(number, Box{x, y, x, y}).first->second;
      box = {std::min(box.left, x),   std::min(box.top, y), std::max(box.right, x),
             std::max(box.bottom, y), box.area + 1,         box.probability + probability_[i]};
    }
    Detection2DArray objects;
    objects.header = picture.header;
    for (const auto& [number, box] : boxes) {
      vision_msgs::msg::Detection2D object;
      object.header = picture.header;
      object.id = std::to_string(number);
      object.bbox.center.position.x = 0.5 * (box.left + box.right + 1);
      object.bbox.center.position.y = 0.5 * (box.top + box.bottom + 1);
      object.bbox.size_x = box.right + 1 - box.left;
      object.bbox.size_y = box.bottom + 1 - box.top;
      object.results.resize(1);
      object.results[0].hypothesis.class_id = "moving";
      object.results[0].hypothesis.score = box.probability / box.area;
      objects.detections.push_back(object);
    }
    objects_->publish(objects);
  }

  void Tell() {
    const std::lock_guard lock(mutex_);
    if (taken_ == 0) return;
    std::sort(latencies_.begin(), latencies_.end());
    const size_t count = latencies_.size();
    RCLCPP_INFO(get_logger(),
                "%d pictures, %zu masks, %d dropped; latency %.0f ms (median), 95 %% below %.0f ms",
                taken_, count, dropped_, count == 0 ? 0.0 : latencies_[count / 2],
                count == 0 ? 0.0 : latencies_[count * 95 / 100]);
    taken_ = dropped_ = 0;
    latencies_.clear();
  }

  // Of the worker alone.
  egosieve::SegmenterOptions options_;
  std::optional<egosieve::Segmenter> segmenter_;
  std::vector<float> probability_, numbers_;
  double threshold_ = 0.5, lens_wait_ = 1.0;

  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  Picture::ConstSharedPtr waiting_;
  Clock::time_point arrived_;
  double focal_ratio_ = 0.0;
  int taken_ = 0, dropped_ = 0;  // since Tell()
  std::vector<double> latencies_;
  bool ends_ = false;

  rclcpp::Publisher<Picture>::SharedPtr mask_;
  rclcpp::Publisher<Detection2DArray>::SharedPtr objects_;
  rclcpp::Subscription<Picture>::SharedPtr pictures_;
  rclcpp::Subscription<CameraInfo>::SharedPtr lenses_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::thread worker_;
};

}  // namespace

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<SegmenterNode>());
  rclcpp::shutdown();
  return 0;
}
