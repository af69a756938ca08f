// The part of rclcpp that the example of ROS 2 uses, within one process: a message reaches the
// subscriptions of its topic in the publisher's thread. spin() hands over to a player, which
// publishes pictures; Debian has no rclcpp to test with.
#pragma once

#include <any>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace builtin_interfaces::msg {
struct Time {
  int32_t sec = 0;
  uint32_t nanosec = 0;
};
}  // namespace builtin_interfaces::msg

namespace std_msgs::msg {
struct Header {
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;
};
}  // namespace std_msgs::msg

namespace rclcpp {

// Of the process: arguments "-p NAME:=VALUE", and subscriptions by topic.
struct Process {
  std::map<std::string, std::string> parameters;
  std::map<std::string, std::vector<std::any>> subscriptions;
  std::vector<std::function<void()>> timers;  // called by the player
};
inline Process& TheProcess() {
  static Process process;
  return process;
}

template <typename Message>
using Callback = std::function<void(std::shared_ptr<const Message>)>;

template <typename Message>
void Deliver(const std::string& topic, const Message& message) {
  const auto shared = std::make_shared<const Message>(message);
  for (const std::any& callback : TheProcess().subscriptions[topic]) {
    std::any_cast<const Callback<Message>&>(callback)(shared);
  }
}

class QoS {
 public:
  QoS(size_t depth) : depth_(depth) {}
  QoS& keep_last(size_t depth) {
    depth_ = depth;
    return *this;
  }

 private:
  size_t depth_;
};
struct SensorDataQoS : QoS {
  SensorDataQoS() : QoS(5) {}
};

template <typename Message>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;
  explicit Publisher(std::string topic) : topic_(std::move(topic)) {}
  void publish(const Message& message) { Deliver(topic_, message); }

 private:
  std::string topic_;
};
template <typename Message>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
};

class Time {
 public:
  Time(const builtin_interfaces::msg::Time& time) : seconds_(time.sec + 1e-9 * time.nanosec) {}
  double seconds() const { return seconds_; }

 private:
  double seconds_;
};

struct Logger {};
#define RCLCPP_INFO(logger, ...) ((void)(logger), std::printf(__VA_ARGS__), std::puts(""))
#define RCLCPP_ERROR(logger, ...) RCLCPP_INFO(logger, __VA_ARGS__)

inline void Read(const std::string& text, std::string& value) { value = text; }
inline void Read(const std::string& text, double& value) { value = std::stod(text); }

class Node {
 public:
  explicit Node(const std::string& /*name*/) {}
  virtual ~Node() = default;

  template <typename T>
  T declare_parameter(const std::string& name, T value) {
    const auto given = TheProcess().parameters.find(name);
    if (given != TheProcess().parameters.end()) Read(given->second, value);
    return value;
  }
  template <typename Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, QoS /*qos*/) {
    return std::make_shared<Publisher<Message>>(topic);
  }
  template <typename Message>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic,
                                                                QoS /*qos*/,
                                                                Callback<Message> callback) {
    TheProcess().subscriptions[topic].push_back(std::move(callback));
    return std::make_shared<Subscription<Message>>();
  }
  TimerBase::SharedPtr create_wall_timer(std::chrono::seconds /*period*/,
                                         std::function<void()> callback) {
    TheProcess().timers.push_back(std::move(callback));
    return std::make_shared<TimerBase>();
  }
  Logger get_logger() const { return {}; }
};

inline void init(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const size_t equals = argument.find(":=");
    if (equals == std::string::npos) continue;
    TheProcess().parameters[argument.substr(0, equals)] = argument.substr(equals + 2);
  }
}
inline void shutdown() { TheProcess().subscriptions.clear(); }
void spin(const std::shared_ptr<Node>& node);  // the player's

}  // namespace rclcpp
