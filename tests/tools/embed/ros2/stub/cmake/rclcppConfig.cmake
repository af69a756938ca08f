# The stub of rclcpp, and the player in the place of its spin().
add_library(rclcpp::rclcpp INTERFACE IMPORTED)
get_filename_component(stub "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
find_package(Threads REQUIRED)
set_target_properties(rclcpp::rclcpp PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${stub}"
  INTERFACE_SOURCES "${stub}/../player.cc"
  INTERFACE_LINK_LIBRARIES Threads::Threads)
