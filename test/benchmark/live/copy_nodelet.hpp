#pragma once

#include "bs_car_odometry/WheelTicks.h"

#include <nodelet/nodelet.h>
#include <ros/ros.h>

namespace bs_car_odometry::benchmarks {

/// What a nodelet costs that does nothing: `wheel_ticks` in, a copy out on `copy`.
class CopyNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    publisher_ = getNodeHandle().advertise<WheelTicks>("copy", 200);
    subscriber_ = getNodeHandle().subscribe("wheel_ticks", 200, &CopyNodelet::copy, this,
                                            ros::TransportHints().tcpNoDelay());
  }
  void copy(const WheelTicks& message) { publisher_.publish(boost::make_shared<WheelTicks>(message)); }

  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace bs_car_odometry::benchmarks
