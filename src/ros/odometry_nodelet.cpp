#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/odometry_ros.hpp"

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <exception>
#include <memory>

namespace bs_car_odometry {

/// The odometry as a nodelet. One that cannot start idles and says why; its manager and neighbours live on.
class OdometryNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    // An exception that leaves onInit can take the whole manager down.
    try {
      odometry_ = std::make_unique<OdometryRos>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      reportFailure(error.what());
    } catch (...) {
      reportFailure("unknown error");
    }
  }

  void reportFailure(const std::string& reason) {
    NODELET_ERROR_STREAM(getName() << " does not run. " << reason);
    failure_ = std::make_unique<FailureReport>(getNodeHandle(), getPrivateNodeHandle(), reason);
  }

  std::unique_ptr<OdometryRos> odometry_;
  std::unique_ptr<FailureReport> failure_;
};

}  // namespace bs_car_odometry

PLUGINLIB_EXPORT_CLASS(bs_car_odometry::OdometryNodelet, nodelet::Nodelet)
