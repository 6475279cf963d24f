#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/first_order_covariance.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace bs_car_odometry {

/// Motion of base_link from one stamp to another.
struct MotionEstimate {
  Pose2 motion;                ///< pose of base_link at the second stamp in base_link at the first
  Eigen::Matrix3d covariance;  ///< of (x, y, yaw) [m, m, rad], in the axes of base_link at the first stamp
  double distance{0.0};        ///< [m] path length of base_link, forwards and backwards both counted
  Duration unseen{0};          ///< time in which the motion was not seen; the covariance answers for it
};

/// The motion from the second stamp to the first.
MotionEstimate inverse(const MotionEstimate& motion);

/// The latest steps of a drive, from which the motion between any two of their stamps follows with its
/// covariance (docs/model.md, 5.8). The covariance is propagated anew from zero at the first stamp: the
/// difference of two pose covariances would lose its digits, and a pose that was set in between. Motion that
/// was not seen is a step too. Steps follow each other without a break. Allocates only when it is made.
class MotionHistory {
 public:
  /// Of the longest history: 60 s at 273 Hz, 5.8 MB.
  static constexpr std::size_t kMostSteps = 16384;

  /// @param longest     steps that ended longer ago than this are dropped; zero keeps none
  /// @param systematic  Sigma_A
  /// @param most_steps  bound on the steps that are kept, whatever their rate
  MotionHistory(Duration longest, const SystematicCovariance& systematic,
                std::size_t most_steps = kMostSteps);

  /// Adds a step. One that does not begin where the newest one ends begins the history anew.
  /// @param span            its stamps, the second one after the first
  /// @param steering_doubt  standard deviation of each sensor's error beyond its noise [rad], see
  /// SteeringDoubt
  /// @param within          (x, y, yaw) variances of motion that was not seen while the step lasted, the same
  ///                        for x and y [m^2, m^2, rad^2]; zero where the twist may be taken as constant.
  ///                        They matter to stamps inside the step, not to the step as a whole.
  void addStep(const TimeSpan& span, const BodyIncrement& increment, const PerAxle<double>& steering_doubt,
               const Eigen::Vector3d& within);

  /// Adds a time in which the motion was not seen and has this (x, y, yaw) covariance [m, m, rad].
  void addUnseen(const TimeSpan& span, const Eigen::Matrix3d& covariance);

  /// Goes on with other values of the parameters: what the steps have moved is put right by J change, to
  /// first order, and Sigma_A is that of the new values.
  /// @param change  new values less those so far
  void setParameters(const Eigen::Matrix<double, systematic::kCount, 1>& change,
                     const SystematicCovariance& systematic);

  /// Forgets every step.
  void clear();

  Duration longest() const { return longest_; }
  std::size_t size() const { return size_; }

  /// What the steps span; none without a step.
  std::optional<TimeSpan> span() const;

  /// Motion from one stamp to another, in whatever order; between the ends of a step its part of the step.
  /// @return none when a stamp lies outside the span, or when the result is not finite
  std::optional<MotionEstimate> between(Time from, Time to) const;

 private:
  friend class MotionAccumulation;

  struct Step {
    TimeSpan span;
    BodyMotion motion;
    Eigen::Matrix3d path_covariance;
    SystematicSensitivity J_motion_systematic;
    PerAxle<double> steering_doubt;
    Eigen::Vector3d within;
    bool seen{true};
  };

  Step* append(const TimeSpan& span);
  /// Where the i-th oldest is; a remainder would cost more than the rest of append().
  std::size_t place(std::size_t i) const {
    const std::size_t place = oldest_ + i;
    return place < capacity_ ? place : place - capacity_;
  }
  const Step& step(std::size_t i) const { return steps_[place(i)]; }
  void dropOldest();
  std::size_t firstEndingAfter(Time stamp) const;
  MotionEstimate accumulate(Time from, Time to) const;

  Duration longest_;
  SystematicRoot systematic_root_;
  std::size_t capacity_;
  std::vector<Step> steps_;  ///< a ring once it is full; memory is touched as steps come
  std::size_t oldest_{0};
  std::size_t size_{0};
};

}  // namespace bs_car_odometry
