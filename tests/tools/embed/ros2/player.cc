// Plays pictures to the example of ROS 2, in the place of rclcpp::spin, and prints what comes out:
// "mask N PIXELS", "objects N MILLISECONDS X Y WIDTH HEIGHT ...", where N is the number of the picture
// by its time, and MILLISECONDS have passed since it was published. Variables of the environment:
//
//   PLAY    file of WIDTH x HEIGHT grey pictures, one after the other
//   WIDTH, HEIGHT
//   RATE    pictures per second: each at its time, as a camera sends them. 0: in bursts of BURST at
//           once, each after the mask of the last one of the burst before
//   FOCAL   in pixels, for camera_info; 0: none is sent
#include <condition_variable>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>

#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"
#include "vision_msgs/msg/detection2_d_array.hpp"

namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;
using vision_msgs::msg::Detection2DArray;

using Clock = std::chrono::steady_clock;

constexpr double kStep = 1.0 / 30.0;  // of the pictures' times, seconds

double Number(const char* name) {
  const char* const text = std::getenv(name);
  return text == nullptr ? 0.0 : std::atof(text);
}

int NumberOf(const std_msgs::msg::Header& header) {
  return static_cast<int>(rclcpp::Time(header.stamp).seconds() / kStep + 0.5);
}

// What has come out, and waiting for it.
class Outcome {
 public:
  Outcome() {
    auto& topics = rclcpp::TheProcess().subscriptions;
    topics["mask"].push_back(rclcpp::Callback<Image>([this](auto mask) {
      const std::lock_guard lock(mutex_);
      int pixels = 0;
      for (const uint8_t value : mask->data) pixels += value == 255;
      std::printf("mask %d %d\n", NumberOf(mask->header), pixels);
    }));
    topics["objects"].push_back(rclcpp::Callback<Detection2DArray>([this](auto objects) {
      const std::lock_guard lock(mutex_);
      last_ = NumberOf(objects->header);
      const std::chrono::duration<double, std::milli> latency = Clock::now() - sent_[last_];
      std::printf("objects %d %.1f", last_, latency.count());
      for (const auto& object : objects->detections) {
        const auto& box = object.bbox;
        std::printf(" %g %g %g %g", box.center.position.x, box.center.position.y, box.size_x,
                    box.size_y);
      }
      std::puts("");
      changed_.notify_all();
    }));
  }

  void Sent(int number) {
    const std::lock_guard lock(mutex_);
    sent_[number] = Clock::now();
  }

  void WaitFor(int number) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return last_ == number; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int last_ = -1;
  std::map<int, Clock::time_point> sent_;
};

void Play(Outcome& outcome) {
  const auto width = static_cast<uint32_t>(Number("WIDTH"));
  const auto height = static_cast<uint32_t>(Number("HEIGHT"));
  const double rate = Number("RATE");
  const int burst = static_cast<int>(Number("BURST"));
  if (Number("FOCAL") > 0.0) {
    CameraInfo lens;
    lens.width = width;
    lens.height = height;
    lens.k[0] = lens.k[4] = Number("FOCAL");
    rclcpp::Deliver("camera_info", lens);
  }
  Image picture;
  picture.width = picture.step = width;
  picture.height = height;
  picture.encoding = "mono8";
  picture.data.resize(static_cast<size_t>(width) * height);
  std::ifstream file(std::getenv("PLAY"), std::ios::binary);
  const auto begin = Clock::now();
  int number = 0, told = 0;
  for (; file.read(reinterpret_cast<char*>(picture.data.data()), picture.data.size()); ++number) {
    const double time = kStep * number;
    picture.header.stamp.sec = static_cast<int32_t>(time);
    picture.header.stamp.nanosec = static_cast<uint32_t>(1e9 * (time - picture.header.stamp.sec));
    if (rate > 0.0) {
      std::this_thread::sleep_until(begin + std::chrono::duration<double>(number / rate));
      for (; told < static_cast<int>(number / rate); ++told) rclcpp::TheProcess().timers[0]();
    } else if (number > 0 && number % burst == 0) {
      outcome.WaitFor(number - 1);
      rclcpp::TheProcess().timers[0]();
    }
    outcome.Sent(number);
    rclcpp::Deliver("image", picture);
  }
  outcome.WaitFor(number - 1);
}

}  // namespace

void rclcpp::spin(const std::shared_ptr<Node>& /*node*/) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  static Outcome outcome;
  Play(outcome);
}
