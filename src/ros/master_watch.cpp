#include "bs_car_odometry/ros/master_watch.hpp"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include <chrono>

namespace bs_car_odometry {

namespace {

constexpr double kPeriod = 2.0;  // [s]

/// What is wrong, with the remedy; null when nothing is.
const char* lookForMaster() {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue payload;
  request[0] = ros::this_node::getName();
  request[1] = ros::this_node::getName();
  if (ros::master::execute("lookupNode", request, response, payload, false)) return nullptr;
  if (!response.valid())
    return "the master does not answer: data keep flowing, but nobody new finds this node; start the master";
  return "the master was started anew and does not know this node: data keep flowing, but nobody new finds "
         "it; start it again, which respawn does by itself (README, \"When the master restarts\")";
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

void MasterWatch::warn() {
  const char* const finding = finding_;
  if (finding != nullptr && log_.isDue()) ROS_WARN_STREAM(finding);
}

void MasterWatch::addTo(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  const char* const finding = finding_;
  if (finding != nullptr) status.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN, finding);
}

bool MasterWatch::stopsWithin(double seconds) {
  std::unique_lock<std::mutex> lock(mutex_);
  return stopping_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return stopped_; });
}

void MasterWatch::run() {
  while (!stopsWithin(kPeriod)) finding_ = lookForMaster();
}

}  // namespace bs_car_odometry
