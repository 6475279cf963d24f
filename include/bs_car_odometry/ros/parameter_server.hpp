#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>
#include <yaml-cpp/yaml.h>

namespace bs_car_odometry {

/// A parameter server's value as a YAML tree: structs become maps, arrays sequences, everything else a
/// scalar; doubles keep every digit. An unset value is null.
YAML::Node toYaml(const XmlRpc::XmlRpcValue& value);

/// Everything below the private namespace of `private_node`, asked of the parameter server once; an empty map
/// when nothing is set there. What changes on the server later has no effect.
YAML::Node parameterServerTree(const ros::NodeHandle& private_node);

}  // namespace bs_car_odometry
