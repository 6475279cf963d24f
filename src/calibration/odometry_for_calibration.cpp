#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"

namespace bs_car_odometry::calibration {

Parameters odometryForCalibration(Parameters parameters) {
  parameters.relative_motion.history = Duration::zero();
  parameters.odometry.uncertainty = Uncertainty::kFirstOrder;
  parameters.odometry.fault_detection = false;
  return parameters;
}

}  // namespace bs_car_odometry::calibration
