#include "bs_car_odometry/parameters/configuration.hpp"

namespace bs_car_odometry {

OdometryConfiguration toConfiguration(const Parameters& parameters) {
  OdometryConfiguration configuration{parameters.vehicle,
                                      parameters.noise,
                                      parameters.odometry,
                                      parameters.limits,
                                      parameters.initial_pose,
                                      parameters.relative_motion,
                                      parameters.systematic_covariance};
  if (parameters.input == InputSource::kJointStates) {
    for (double& metres : configuration.vehicle.metres_per_tick.values) metres /= kTicksPerRadian;
    configuration.vehicle.counter_bits = 0;
  }
  return configuration;
}

}  // namespace bs_car_odometry
