#include "bs_car_odometry/core/steering_doubt.hpp"

namespace bs_car_odometry {

void SteeringDoubt::advance(const PoseStep& step, const SystematicSensitivity& J_motion,
                            const PerAxle<double>& sigma) {
  Columns J;
  J << J_motion.col(systematic::kFrontOffset) * sigma.front,
      J_motion.col(systematic::kRearOffset) * sigma.rear;
  sensitivity_ = step.J_pose_pose() * sensitivity_ + step.J_pose_motion() * J;
}

}  // namespace bs_car_odometry
