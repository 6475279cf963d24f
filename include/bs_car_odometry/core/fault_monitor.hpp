#pragma once

#include "bs_car_odometry/core/fault_isolation.hpp"
#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/core/pending_readings.hpp"
#include "bs_car_odometry/core/sensor_faults.hpp"
#include "bs_car_odometry/core/steady_wheels.hpp"
#include "bs_car_odometry/core/wheel_fit.hpp"

#include <array>
#include <optional>

namespace bs_car_odometry {

/// Watches over the sensors of a car: leaves out those that contradict the others, says what is wrong with
/// them, and takes them back when they agree again (docs/model.md, 6.1). A gross fault is seen in the
/// step that has it, before the step moves the car; a small one in what a tenth of a second, or a second,
/// sums up to. Works with the fit of both axles; where only two wheels are read nothing is left over.
class FaultMonitor {
 public:
  explicit FaultMonitor(const OdometryConfiguration& configuration);

  /// Everything is sound again.
  void reset();
  /// Other parameters; what is left out stays so.
  void setConfiguration(const OdometryConfiguration& configuration);

  /// True when the odometry should not read a step as it was measured.
  bool distrusts(const StepReadings& measured) const {
    return out_.any() || (all_wheels_ && measured.isDoubted());
  }
  /// The step as it should be read: without the sensors that are left out; in the place of an angle that is
  /// doubted, the one by which the car has last moved.
  StepReadings trusted(const StepReadings& measured) const { return without(out_, measured); }

  /// Looks for a gross fault in a step before it moves the car.
  /// @param readings   as they were read
  /// @param residuals  that they left
  /// @return true when more has been left out, and the step must be read again
  bool contradicts(const StepReadings& readings, const FitResiduals& residuals);

  /// Takes in a step that has moved the car.
  /// @param interval  its duration, where it is known
  /// @return covariance (x, y, yaw; axes of base_link) of what a fault has done to the pose before it was
  /// found,
  ///         and of a motion that is a guess
  std::optional<Eigen::Matrix3d> add(const StepReadings& measured, const BodyIncrement& increment,
                                     std::optional<Duration> interval);

  /// True when the motion is known without these wheels and what is left out already.
  bool canDoWithout(const PerWheel<bool>& wheels) const;

  const SensorReport& report() const { return report_; }
  bool leavesOut(Wheel wheel) const { return out_[sensor(wheel)]; }

 private:
  /// Evidence of the latest stretches, for faults that one alone does not show.
  struct Window {
    static constexpr std::size_t kStretches = 10;
    std::array<ParameterEvidence, kStretches> evidence;
    std::array<double, kStretches> lengths;  ///< [m]
    std::size_t count{0};
    void add(const ParameterEvidence& newest, double length);
    const ParameterEvidence& newest() const { return evidence[count - 1]; }
    ParameterEvidence sum() const;
    double sumOfLengths() const;
  };
  /// Of a sensor that is left out.
  struct Inspection {
    ParameterEvidence evidence;  ///< with it, since it was last judged
    double found{0.0};           ///< deviation for which it was left out
    int sound{0};                ///< times in succession that it was found to be sound,
    double first_angle{0.0};     ///< its reading when it was so first [rad]
  };
  /// A sensor that may have been left out in a suspect's place.
  struct Reconsidered {
    std::size_t suspect{0};
    int stretches{0};         ///< in succession that this would explain
    double first_angle{0.0};  ///< its reading in the first of them [rad]
  };
  /// Where an axle goes, by the motion of the car.
  struct Course {
    double angle{0.0};     ///< [rad]
    double variance{1.0};  ///< [rad^2]
  };

  StepReadings without(const SensorSet& out, const StepReadings& measured) const;
  bool determines(const SensorSet& out) const;
  int spareEquations(const SensorSet& out) const;
  bool leaveOut(const Suspects& suspects, const SensorTests& tests);
  void follow(const BodyIncrement& increment, double interval);
  void startStretch();
  Suspects blame(const SensorTests& tests, const StepReadings& readings, double length) const;
  BodyMotion judge(const StepReadings& stretch);
  void followFrozen(const StepReadings& stretch, double seconds);
  BodyMotion judgeFrozen(const StepReadings& stretch);
  bool isFrozen(Wheel wheel, const StepReadings& stretch, double seconds) const;
  double speedOf(Wheel wheel, const StepReadings& stretch, double seconds) const;
  void reconsider(std::size_t suspect, const StepReadings& stretch);
  bool makesSenseWithout(std::size_t suspect, std::size_t innocent, const StepReadings& stretch) const;
  bool makesSense(const StepReadings& readings) const;
  Eigen::Matrix3d guess(double length);
  void inspectSensors(const StepReadings& measured);
  void inspect(std::size_t sensor, const StepReadings& measured);
  void inspectSwaps(const StepReadings& measured);
  double chiSquareSwapped(std::size_t a, std::size_t b, StepReadings readings) const;
  bool isSwapped(std::size_t a, std::size_t b, const StepReadings& measured) const;
  void describe(const Suspects& suspects, const SensorTests& tests, const StepReadings& measured);
  void describe(std::size_t sensor, const StepReadings& measured, const SensorTest& test);
  void takeBack(std::size_t sensor);

  OdometryConfiguration configuration_;
  SystematicCovariance prior_;
  WheelFit fit_;
  SteadyWheels steady_;
  bool all_wheels_;  ///< the fit of both axles
  bool enabled_;
  bool follows_law_;  ///< the rear angle follows from the front one
  SensorSet present_;
  SensorSet out_;
  SensorSet undecided_;  ///< of these, those that were left out with others
  SensorSet likeliest_;  ///< of these, those for one of several, which could not all be spared
  SensorSet swapped_;    ///< of these, those that have each other's counters: never taken back
  SensorSet frozen_;     ///< wheels that have said the same speed ever since the car had another
  SensorReport report_;
  std::array<Inspection, kSensors> inspections_;
  std::array<Reconsidered, kSensors> reconsidered_{};
  /// One that the rest contradict and cannot do without: with it they may agree again, on a wrong motion.
  std::optional<std::size_t> needed_suspect_;
  int guesses_{0};  ///< successive stretches whose motion is a guess
  /// Successive stretches that a swap of two wheels explains.
  std::array<std::array<int, kWheels>, kWheels> swap_votes_{};
  PerAxle<Course> course_;
  PendingReadings measured_;  ///< of the present stretch
  double elapsed_{0.0};       ///< [s] since the stretch began
  Window window_;
};

}  // namespace bs_car_odometry
