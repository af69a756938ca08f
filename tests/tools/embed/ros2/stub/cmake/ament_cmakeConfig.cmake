# What the example of ROS 2 asks of ament_cmake.
macro(ament_package)
endmacro()
