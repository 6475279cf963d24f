// What it costs to keep the steps for ~relative_motion, per step of the pipeline, and what an answer costs.
#include "drive.hpp"

#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>

namespace bs_car_odometry::benchmarks {
namespace {

constexpr Duration kPeriod = durationFromSeconds(0.02);

/// Drives the slalom through a pipeline, message by message and without an end.
class PipelineDrive {
 public:
  explicit PipelineDrive(double history) : pipeline_(configuration(history)) {}

  void step() {
    const StepReadings& readings = drive_[i_++ % kSteps];
    stamp_ += kPeriod;
    for (const Wheel wheel : kAllWheels) {
      travel_[wheel] += readings.travel[wheel];
      counts_.ticks[wheel] = std::llround(travel_[wheel] / kMetresPerTick);
    }
    counts_.stamp = counts_.receipt = stamp_;
    pipeline_.addSteering(Axle::kFront, stamp_, stamp_, readings.end.front);
    pipeline_.addWheels(counts_);
    const std::optional<OdometryUpdate> update = pipeline_.next(stamp_);
    benchmark::DoNotOptimize(update);
  }

  const MotionHistory& history() const { return pipeline_.motionHistory(); }

 private:
  static OdometryConfiguration configuration(double history) {
    OdometryConfiguration configuration;
    configuration.vehicle = cycab();
    configuration.relative_motion.history = durationFromSeconds(history);
    return configuration;
  }

  const std::array<StepReadings, kSteps> drive_ = slalom();
  OdometryPipeline pipeline_;
  std::size_t i_{0};
  Time stamp_ = timeFromNanoseconds(1600000000000000000);
  PerWheel<double> travel_;
  WheelCounts counts_;
};

void run(benchmark::State& state, double history) {
  PipelineDrive drive(history);
  // Once through the ring: memory that is new has a price of its own.
  for (std::size_t i = 0; i < MotionHistory::kMostSteps; ++i) drive.step();
  for (auto _ : state) drive.step();
}

void pipelineStep(benchmark::State& state) { run(state, 0.0); }
void pipelineStepWithHistory(benchmark::State& state) { run(state, 60.0); }

/// Over all of 60 s at 50 Hz.
void relativeMotionOfAMinute(benchmark::State& state) {
  PipelineDrive drive(60.0);
  while (drive.history().size() < 3000) drive.step();
  const TimeSpan span = *drive.history().span();
  for (auto _ : state) benchmark::DoNotOptimize(drive.history().between(span.begin, span.end));
}

BENCHMARK(pipelineStep);
BENCHMARK(pipelineStepWithHistory);
BENCHMARK(relativeMotionOfAMinute);

}  // namespace
}  // namespace bs_car_odometry::benchmarks
