#include "bs_car_odometry/core/odometry_model.hpp"

namespace bs_car_odometry {

OdometryModel makeOdometryModel(const OdometryConfiguration& configuration) {
  const OdometryConfiguration& c = configuration;
  if (c.options.axles == AxleSelection::kBoth) return WheelFit(c.vehicle, c.noise);
  const Axle axle = c.options.axles == AxleSelection::kFront ? Axle::kFront : Axle::kRear;
  return AxleOdometry(c.vehicle, c.noise, c.options, axle);
}

}  // namespace bs_car_odometry
