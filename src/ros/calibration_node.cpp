#include "bs_car_odometry/ros/calibration_ros.hpp"

#include <ros/ros.h>

#include <exception>

int main(int argc, char** argv) {
  ros::init(argc, argv, "calibration");
  // Outlives what may be thrown: the last handle shuts the log down.
  const ros::NodeHandle node;
  try {
    bs_car_odometry::CalibrationRos calibration(node, ros::NodeHandle("~"));
    ros::spin();
    calibration.end();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("the calibration does not run. " << error.what());
    return 1;
  }
  return 0;
}
