#include "bs_car_odometry/core/pose_uncertainty.hpp"

#include "bs_car_odometry/core/first_order_covariance.hpp"
#include "bs_car_odometry/core/moment_uncertainty.hpp"
#include "bs_car_odometry/core/particle_cloud.hpp"

namespace bs_car_odometry {

namespace {

std::unique_ptr<PoseUncertainty> makeMethod(const OdometryConfiguration& configuration) {
  const OdometryOptions& options = configuration.options;
  switch (options.uncertainty) {
    case Uncertainty::kExactMoments:
      return std::make_unique<ExactMoments>(SystematicPrior(configuration), options.systematic_rule);
    case Uncertainty::kClosedForm:
      return std::make_unique<ClosedForm>();
    case Uncertainty::kPaper2Simplified:
      return std::make_unique<Paper2Simplified>();
    case Uncertainty::kMonteCarlo:
      return std::make_unique<ParticleCloud>(configuration);
    case Uncertainty::kFirstOrder:
      break;
  }
  return std::make_unique<FirstOrderCovariance>(configuration.initial_pose.covariance);
}

}  // namespace

std::unique_ptr<PoseUncertainty> makePoseUncertainty(const OdometryConfiguration& configuration) {
  std::unique_ptr<PoseUncertainty> uncertainty = makeMethod(configuration);
  const InitialPose& initial = configuration.initial_pose;
  uncertainty->reset({initial.x, initial.y, initial.yaw}, initial.covariance);
  return uncertainty;
}

}  // namespace bs_car_odometry
