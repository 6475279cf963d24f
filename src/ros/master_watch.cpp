#include "bs_car_odometry/ros/master_watch.hpp"

#include <ros/master.h>
#include <ros/this_node.h>

#include <chrono>

namespace bs_car_odometry {

namespace {

constexpr double kPeriod = 2.0;  // [s]

const char* lookForMaster() {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue payload;
  request[0] = ros::this_node::getName();
  request[1] = ros::this_node::getName();
  if (ros::master::execute("lookupNode", request, response, payload, false)) return "";
  if (!response.valid())
    return "the master does not answer: data keep flowing, but nobody new finds this node; start the master";
  return "the master was started anew and does not know this node: data keep flowing, but nobody new finds "
         "it; "
         "start it again, which respawn does by itself (README, \"When the master restarts\")";
}

}  // namespace

MasterWatch::MasterWatch() : thread_([this] { run(); }) {}

MasterWatch::~MasterWatch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  stopping_.notify_all();
  thread_.join();
}

bool MasterWatch::stopsWithin(double seconds) {
  std::unique_lock<std::mutex> lock(mutex_);
  return stopping_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return stopped_; });
}

void MasterWatch::run() {
  while (!stopsWithin(kPeriod)) finding_ = lookForMaster();
}

}  // namespace bs_car_odometry
