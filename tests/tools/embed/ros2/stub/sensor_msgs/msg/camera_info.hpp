// The fields of sensor_msgs/CameraInfo that the example reads.
#pragma once

#include <array>

#include "rclcpp/rclcpp.hpp"

namespace sensor_msgs::msg {
struct CameraInfo {
  using ConstSharedPtr = std::shared_ptr<const CameraInfo>;
  std_msgs::msg::Header header;
  uint32_t height = 0, width = 0;
  std::array<double, 9> k{};
};
}  // namespace sensor_msgs::msg
