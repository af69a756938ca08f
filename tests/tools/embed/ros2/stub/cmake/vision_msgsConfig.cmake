# Its headers are those of the stub of rclcpp.
set(vision_msgs_TARGETS rclcpp::rclcpp)
