#pragma once

#include "bs_car_odometry/core/held_errors.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"
#include "bs_car_odometry/core/particle_plan.hpp"
#include "bs_car_odometry/core/pose_uncertainty.hpp"
#include "bs_car_odometry/core/worker_pool.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bs_car_odometry {

/// P1's Bayesian model (3) to (5), numerically (docs/model.md, section 5.6 and (5')): particles, each of
/// which drives with parameters of its own, drawn once from p(A), and with errors of the readings of its own,
/// p(U).
///
/// Poses are held as departures from the dead-reckoned one. What a particle draws depends on the seed, the
/// step and the particle alone: threads do not change the cloud.
class ParticleCloud final : public PoseUncertainty {
 public:
  explicit ParticleCloud(const OdometryConfiguration& configuration);
  ~ParticleCloud() override;

  void reset(const Pose2& pose, const Eigen::Matrix3d& covariance) override;
  void advance(const UncertainStep& step) override;
  /// Kept beside the cloud, to first order: a heading that may be anywhere would leave the particles no mean.
  void inflate(const Eigen::Matrix3d& covariance) override { unseen_ += covariance; }
  void setSystematic(const SystematicPrior& prior, const SystematicCovariance& carried) override;
  void getTotal(Eigen::Matrix3d& total) const override { total = covariance_ + unseen_; }

  /// The expected pose, which lags behind the dead-reckoned one.
  std::optional<Pose2> mean() const override;

  /// Of the first 10,000 particles at most.
  std::optional<PoseQuantiles> quantiles() override;
  std::size_t particles() const override { return x_.size(); }
  Pose2 particle(std::size_t i) const override;

 private:
  struct Workspace;
  struct Block {
    std::size_t first;
    std::size_t count;
  };

  template <typename Work>
  void forEachBlock(const Work& work);
  DrawNumber number(std::uint32_t purpose) const { return {seed_, step_, purpose}; }
  void move(const ParticlePlan& plan, const Block& block, Workspace& w);
  void addGains(const ParticlePlan& plan, const Block& block, Workspace& w) const;
  void addNoise(const ParticlePlan& plan, const Block& block, Workspace& w) const;
  void addAngleErrors(const ParticlePlan& plan, const Block& block, Workspace& w);
  void addDraws(const Eigen::Matrix3d& covariance, std::uint32_t purpose);
  void drawParameters(const SystematicPrior& prior, const SystematicCovariance& carried);
  void keepParameters(const SystematicCovariance& kept, const Block& block);
  void setUncertain(const SystematicCovariance& L, const SystematicPrior& prior);
  void setMoments();
  PoseQuantiles::Values quantilesOf(const std::vector<double>& departures, double reference);

  ParticlePlanner planner_;
  SystematicPrior prior_;
  std::uint64_t seed_;
  std::uint32_t step_{0};

  Pose2 reference_;                  ///< the dead-reckoned pose
  std::vector<double> x_, y_, yaw_;  ///< departures from it, in odom [m, m, rad]
  /// Errors of the parameters, in the order of `systematic`; all the same zeros where there are none.
  std::array<std::vector<float>, systematic::kCount> parameters_;
  std::array<bool, systematic::kCount> uncertain_{};  ///< the parameters that have errors
  PerAxle<HeldErrors> held_;
  PerAxle<HeldErrors::Step> held_step_;

  WorkerPool pool_;
  std::vector<Workspace> workspaces_;  ///< one for each thread
  std::vector<BlockMoments> moments_;  ///< one for each block
  Eigen::Vector3d mean_;               ///< of the departures
  Eigen::Matrix3d covariance_;
  Eigen::Matrix3d unseen_{Eigen::Matrix3d::Zero()};  ///< of motion that was not seen
  std::vector<double> sorted_;
};

}  // namespace bs_car_odometry
