// MRPT's dead reckoning of a differential robot with a covariance, over the drive of the other benchmark.
#include "drive.hpp"

#include <benchmark/benchmark.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/poses/CPosePDFGaussian.h>

#include <cmath>

namespace bs_car_odometry::benchmarks {
namespace {

using mrpt::obs::CActionRobotMovement2D;
using mrpt::poses::CPosePDFGaussian;

struct EncoderTicks {
  int left;
  int right;
};

std::array<EncoderTicks, kSteps> slalomTicks() {
  std::array<EncoderTicks, kSteps> ticks{};
  const std::array<StepReadings, kSteps> drive = slalom();
  for (std::size_t i = 0; i < kSteps; ++i)
    ticks[i] = {static_cast<int>(std::lround(drive[i].travel[Wheel::kRearLeft] / kMetresPerTick)),
                static_cast<int>(std::lround(drive[i].travel[Wheel::kRearRight] / kMetresPerTick))};
  return ticks;
}

CActionRobotMovement2D makeAction() {
  CActionRobotMovement2D action;
  action.motionModelConfiguration.modelSelection = CActionRobotMovement2D::mmGaussian;
  action.hasEncodersInfo = true;
  return action;
}

void compose(CActionRobotMovement2D& action, const EncoderTicks& ticks, CPosePDFGaussian& pose) {
  action.encoderLeftTicks = ticks.left;
  action.encoderRightTicks = ticks.right;
  action.computeFromEncoders(kMetresPerTick, kMetresPerTick, 1.2);
  pose += *static_cast<const CPosePDFGaussian*>(action.poseChange.get());
}

/// The action object made once.
void mrptStep(benchmark::State& state) {
  const std::array<EncoderTicks, kSteps> drive = slalomTicks();
  CPosePDFGaussian pose;
  CActionRobotMovement2D action = makeAction();
  std::size_t i = 0;
  for (auto _ : state) {
    compose(action, drive[i++ % kSteps], pose);
    benchmark::DoNotOptimize(pose);
  }
}

/// The action object made in every step, as MRPT's own applications do.
void mrptStepNewAction(benchmark::State& state) {
  const std::array<EncoderTicks, kSteps> drive = slalomTicks();
  CPosePDFGaussian pose;
  std::size_t i = 0;
  for (auto _ : state) {
    CActionRobotMovement2D action = makeAction();
    compose(action, drive[i++ % kSteps], pose);
    benchmark::DoNotOptimize(pose);
  }
}

BENCHMARK(mrptStep);
BENCHMARK(mrptStepNewAction);

}  // namespace
}  // namespace bs_car_odometry::benchmarks
