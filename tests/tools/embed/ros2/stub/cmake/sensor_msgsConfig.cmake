# Its headers are those of the stub of rclcpp.
set(sensor_msgs_TARGETS rclcpp::rclcpp)
