#include "bs_car_odometry/ros/odometry_ros.hpp"

#include <ros/ros.h>

#include <exception>

int main(int argc, char** argv) {
  ros::init(argc, argv, "odometry");
  // Outlives what may be thrown: the last handle shuts the log down.
  const ros::NodeHandle node;
  try {
    const bs_car_odometry::OdometryRos odometry(node, ros::NodeHandle("~"));
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("the odometry does not run. " << error.what());
    return 1;
  }
  return 0;
}
