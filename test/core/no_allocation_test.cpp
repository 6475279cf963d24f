// No step allocates memory: operator new is counted here, and Eigen's own allocations abort.
#include "vehicles.hpp"

#include "bs_car_odometry/core/fault_monitor.hpp"
#include "bs_car_odometry/core/motion_history.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/core/steering_buffer.hpp"

#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <vector>

namespace {
std::size_t allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace bs_car_odometry {
namespace {

using namespace test_support;

/// Counts from its making on; forbids Eigen's allocations in the meantime.
class AllocationWatch {
 public:
  AllocationWatch() : before_(allocations) { Eigen::internal::set_is_malloc_allowed(false); }
  ~AllocationWatch() { Eigen::internal::set_is_malloc_allowed(true); }
  std::size_t count() const { return allocations - before_; }

 private:
  std::size_t before_;
};

TEST(NoAllocation, TheWatchSeesOne) {
  const AllocationWatch watch;
  const auto value = std::make_unique<int>(1);
  EXPECT_EQ(watch.count(), 1u);
}

TEST(NoAllocation, TheWatchForbidsEigenOne) {
  EXPECT_DEATH(
      {
        const AllocationWatch watch;
        Eigen::VectorXd vector = Eigen::VectorXd::Zero(100);
        std::exit(vector.size() == 100 ? 0 : 1);
      },
      "heap allocation is forbidden");
}

/// A wheel that sticks is found, left out, watched and taken back.
TEST(NoAllocation, N9_StepsWithAFaultyWheel) {
  constexpr Duration kPeriod = std::chrono::milliseconds(20);
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  OdometryEstimator estimator(configuration);
  FaultMonitor monitor(configuration);
  const StepReadings sound = consistentReadings(configuration.vehicle, 0.05, {0.2, -0.2});
  StepReadings stuck = sound;
  stuck.travel[Wheel::kRearLeft] = 0.0;
  {
    const AllocationWatch watch;
    for (int i = 0; i < 200; ++i) {
      const StepReadings& measured = i >= 50 && i < 100 ? stuck : sound;
      StepReadings readings = monitor.trusted(measured);
      if (monitor.contradicts(readings, estimator.read(readings))) {
        readings = monitor.trusted(measured);
        estimator.read(readings);
      }
      estimator.move(readings, kPeriod);
      monitor.add(measured, estimator.lastIncrement(), kPeriod);
    }
    EXPECT_EQ(watch.count(), 0u);
  }
  EXPECT_EQ(monitor.report().exclusions, 1u);
  EXPECT_FALSE(monitor.leavesOut(Wheel::kRearLeft));
}

TEST(NoAllocation, N9_StepOfTheEstimator) {
  std::vector<OdometryOptions> options;
  for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kFront, AxleSelection::kRear})
    for (const Uncertainty method :
         {Uncertainty::kFirstOrder, Uncertainty::kExactMoments, Uncertainty::kClosedForm,
          Uncertainty::kPaper2Simplified, Uncertainty::kMonteCarlo}) {
      options.emplace_back();
      options.back().axles = axles;
      options.back().uncertainty = method;
    }
  for (const Vehicle& vehicle : fourGeometries())
    for (const OdometryOptions& option : options) {
      OdometryConfiguration configuration;
      configuration.vehicle = vehicle;
      configuration.options = option;
      OdometryEstimator estimator(configuration);
      const StepReadings readings = consistentReadings(vehicle, 0.02, slaved(vehicle, 0.2));
      StepReadings broken = readings;
      broken.travel.values.fill(std::numeric_limits<double>::quiet_NaN());
      std::size_t count = 0;
      {
        const AllocationWatch watch;
        for (int i = 0; i < 100; ++i) estimator.step(readings, durationFromSeconds(0.02));
        estimator.step(broken, durationFromSeconds(0.02));
        estimator.inflate(durationFromSeconds(0.1));
        estimator.setPose({}, Eigen::Matrix3d::Identity());
        estimator.reset();
        count = watch.count();
      }
      EXPECT_EQ(count, 0u) << vehicle.name;
    }
  recordFigure("0 allocations in a step");
}

TEST(NoAllocation, N9_FullSteeringBuffer) {
  SteeringBuffer buffer(64);
  double sum = 0.0;
  std::size_t count = 0;
  {
    const AllocationWatch watch;
    for (int i = 0; i < 10000; ++i) {
      const Time stamp(std::chrono::milliseconds(10 * i));
      buffer.insert(stamp, 0.1);
      buffer.insert(stamp - std::chrono::milliseconds(15), 0.1);  // late
      sum += buffer.angleAt(stamp);
    }
    count = watch.count();
  }
  EXPECT_EQ(count, 0u);
  EXPECT_NEAR(sum, 1000.0, 1e-6);
}

/// From its first step on, beyond its fill, and when it is asked.
TEST(NoAllocation, N9_MotionHistory) {
  constexpr int kMost = 64;
  MotionHistory history(durationFromSeconds(60.0), systematicCovariance(SystematicNoise()), kMost);
  const auto at = [](int i) { return Time(std::chrono::milliseconds(10 * i)); };
  BodyIncrement increment;
  increment.motion = {0.02, 0.0, 0.01};
  double sum = 0.0;
  std::size_t count = 0;
  {
    const AllocationWatch watch;
    for (int i = 0; i < 3 * kMost; ++i) {
      history.addStep({at(i), at(i + 1)}, increment, {0.1, 0.0}, Eigen::Vector3d::Zero());
      sum += history.between(at(i), at(i + 1))->distance;
    }
    history.addUnseen({at(3 * kMost), at(3 * kMost + 1)}, Eigen::Matrix3d::Identity());
    sum += history.between(at(3 * kMost), at(3 * kMost - 10))->distance;
    history.clear();
    count = watch.count();
  }
  EXPECT_EQ(count, 0u);
  EXPECT_NEAR(sum, 0.02 * (3 * kMost + 10), 1e-9);
}

}  // namespace
}  // namespace bs_car_odometry
