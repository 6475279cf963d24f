#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/odometry_model.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/systematic_prior.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>

namespace bs_car_odometry {

/// One step as its uncertainty sees it.
struct UncertainStep {
  const PoseStep& moved;                  ///< of the dead-reckoned pose
  const BodyIncrement& increment;         ///< t, its covariance P from independent noise, dt/dA
  const SystematicSensitivity& J_motion;  ///< dt/da = dt/dA L
  const StepReadings& readings;           ///< what the increment was worked out from,
  const OdometryModel& model;             ///< and by what
};

/// Quantiles of x, y [m] and yaw [rad, not wrapped] of base_link in odom, each by itself.
struct PoseQuantiles {
  /// Probabilities below: those of a normal number at -3, -2, ... 3 standard deviations.
  static constexpr std::array<double, 7> kLevels{
      0.0013498980316301, 0.0227501319481792, 0.158655253931457, 0.5,
      0.841344746068543,  0.977249868051821,  0.99865010196837};
  using Values = std::array<double, kLevels.size()>;
  Values x, y, yaw;
};

/// How the uncertainty of the pose is propagated; `odometry/uncertainty` selects one (docs/model.md,
/// section 5). Poses are (x, y, yaw) of base_link in odom [m, m, rad], and every method answers with
/// Sigma_total: the noise of the readings and the constant errors of the parameters.
class PoseUncertainty {
 public:
  virtual ~PoseUncertainty() = default;

  /// Starts again from a pose of this covariance that owes nothing to the parameters.
  virtual void reset(const Pose2& pose, const Eigen::Matrix3d& covariance) = 0;

  virtual void advance(const UncertainStep& step) = 0;

  /// Adds the covariance of motion that was not seen.
  virtual void inflate(const Eigen::Matrix3d& covariance) = 0;

  /// Lets other parameters take the place of those so far, whose effect on the pose stays.
  /// @param carried  how much of the old errors is in the new ones, as carriedOver() has it; zero: nothing
  virtual void setSystematic(const SystematicPrior& prior, const SystematicCovariance& carried) = 0;

  /// Sigma_total; into a matrix that exists: no copy in every step.
  virtual void getTotal(Eigen::Matrix3d& total) const = 0;

  /// True when the latest total was not positive semidefinite, and the nearest one that is was given instead.
  virtual bool repaired() const { return false; }

  /// The pose to publish in the place of the dead-reckoned one, where the method has one.
  virtual std::optional<Pose2> mean() const { return std::nullopt; }

  /// Where the method holds more than two moments.
  virtual std::optional<PoseQuantiles> quantiles() { return std::nullopt; }

  /// How many poses the method carries, and each of them.
  virtual std::size_t particles() const { return 0; }
  virtual Pose2 particle(std::size_t /*i*/) const { return {}; }

  Eigen::Matrix3d total() const {
    Eigen::Matrix3d total;
    getTotal(total);
    return total;
  }

 protected:
  PoseUncertainty() = default;
  PoseUncertainty(const PoseUncertainty&) = default;
  PoseUncertainty& operator=(const PoseUncertainty&) = default;
};

/// The method that the configuration selects, at its initial pose.
std::unique_ptr<PoseUncertainty> makePoseUncertainty(const OdometryConfiguration& configuration);

}  // namespace bs_car_odometry
