#pragma once

#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <string>

namespace bs_car_odometry::testing {

inline Parameters parametersOf(const std::string& node) {
  return loadParameters(parameterServerTree(ros::NodeHandle(node))).parameters;
}

/// Names of four characters, so that the fields after them lie at multiples of four bytes.
inline geometry_msgs::PoseWithCovarianceStamped poseIn(const std::string& frame, const ros::Time& stamp) {
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header.frame_id = frame;
  pose.header.stamp = stamp;
  pose.pose.pose.orientation.w = 1.0;
  for (const std::size_t i : {0, 7, 35}) pose.pose.covariance[i] = 1e-4;
  return pose;
}

/// Two links of now.
inline tf2_msgs::TFMessage link(const std::string& parent, const std::string& child) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(2);
  for (geometry_msgs::TransformStamped& transform : message.transforms) {
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = parent;
    transform.child_frame_id = child;
    transform.transform.rotation.w = 1.0;
  }
  return message;
}

}  // namespace bs_car_odometry::testing
