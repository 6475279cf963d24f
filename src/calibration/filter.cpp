#include "bs_car_odometry/calibration/filter.hpp"

#include "bs_car_odometry/calibration/joint_filter.hpp"
#include "bs_car_odometry/calibration/paper_filter.hpp"

#include <cmath>

namespace bs_car_odometry::calibration {

std::unique_ptr<Filter> makeFilter(const Parameters& parameters) {
  if (parameters.calibration.method == CalibrationMethod::kPaper)
    return std::make_unique<PaperFilter>(parameters);
  return std::make_unique<JointFilter>(parameters);
}

/// zeta_a = k_d (zeta_r + zeta_l) = k_r zeta_r + k_l zeta_l.
void setDistanceGains(const Vehicle& vehicle, FilterEstimate& estimate) {
  for (const Axle axle : kAllAxles) {
    const auto first =
        static_cast<Eigen::Index>(axle == Axle::kFront ? systematic::kFrontRight : systematic::kRearRight);
    const double right = std::abs(vehicle.metres_per_tick[rightWheel(axle)]);
    const double left = std::abs(vehicle.metres_per_tick[leftWheel(axle)]);
    if (right + left == 0.0) continue;
    const Eigen::Vector2d weights = Eigen::Vector2d(right, left) / (right + left);
    estimate.k_d[axle] = weights.dot(estimate.values.segment<2>(first));
    estimate.k_d_variance[axle] = weights.dot(estimate.covariance.block<2, 2>(first, first) * weights);
  }
}

}  // namespace bs_car_odometry::calibration
