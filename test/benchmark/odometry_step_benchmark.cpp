// One odometry step against MRPT's: four wheels and two steering angles to pose and covariance, twist and
// covariance, chi-square, with a full covariance of the systematic parameters.
#include "drive.hpp"
#include "ratio_reporter.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

namespace bs_car_odometry::benchmarks {

Vehicle cycab() {
  Vehicle vehicle;
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  vehicle.base_link_x = 0.6;
  for (const Wheel wheel : kAllWheels) vehicle.metres_per_tick[wheel] = kMetresPerTick;
  return vehicle;
}

std::array<StepReadings, kSteps> slalom() {
  const Vehicle vehicle = cycab();
  constexpr double kStep = 0.02;  // m, and s
  const auto steeringAt = [](std::size_t i) {
    const double phi = 0.3 * std::sin(2.0 * M_PI * static_cast<double>(i) / kSteps);
    return SteeringAngles{phi, -phi};
  };
  std::array<StepReadings, kSteps> drive{};
  for (std::size_t i = 0; i < kSteps; ++i) {
    StepReadings& step = drive[i];
    step.begin = steeringAt(i);
    step.end = steeringAt(i + 1);
    step.travel = wheelSpeeds(vehicle, bodyTwist(vehicle, kStep, step.mean()), step.mean());
  }
  return drive;
}

namespace {

/// As a calibration leaves it: every parameter correlated with every other.
SystematicCovariance fullCovariance() {
  SystematicCovariance L = SystematicCovariance::Constant(1e-3);
  L.diagonal().setConstant(1e-2);
  return L * L.transpose();
}

OdometryEstimator makeEstimator(const OdometryOptions& options) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.options = options;
  OdometryEstimator estimator(configuration);
  estimator.setSystematicCovariance(fullCovariance());
  return estimator;
}

void run(benchmark::State& state, const OdometryOptions& options) {
  const std::array<StepReadings, kSteps> drive = slalom();
  OdometryEstimator estimator = makeEstimator(options);
  const Duration interval = durationFromSeconds(0.02);
  std::size_t i = 0;
  for (auto _ : state) {
    estimator.step(drive[i++ % kSteps], interval);
    benchmark::DoNotOptimize(estimator);
  }
}

OdometryOptions with(Uncertainty uncertainty, SystematicRule rule = SystematicRule::kDegreeFive) {
  OdometryOptions options;
  options.uncertainty = uncertainty;
  options.systematic_rule = rule;
  return options;
}

void fourWheelStep(benchmark::State& state) { run(state, OdometryOptions()); }

void rearAxleStep(benchmark::State& state) {
  OdometryOptions options;
  options.axles = AxleSelection::kRear;
  run(state, options);
}

void exactMomentsSensitivity(benchmark::State& state) {
  run(state, with(Uncertainty::kExactMoments, SystematicRule::kSensitivity));
}

void exactMomentsDegreeFive(benchmark::State& state) { run(state, with(Uncertainty::kExactMoments)); }

void closedForm(benchmark::State& state) { run(state, with(Uncertainty::kClosedForm)); }

BENCHMARK(fourWheelStep);
BENCHMARK(rearAxleStep);
BENCHMARK(exactMomentsSensitivity);
BENCHMARK(exactMomentsDegreeFive);
BENCHMARK(closedForm);

}  // namespace
}  // namespace bs_car_odometry::benchmarks

int main(int argc, char** argv) {
  // Repetitions of the contenders interleaved, so that a change of the processor's clock meets them all
  // alike.
  std::vector<std::string> arguments{argv[0], "--benchmark_enable_random_interleaving=true",
                                     "--benchmark_repetitions=15", "--benchmark_min_time=0.1",
                                     "--benchmark_report_aggregates_only=true"};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(&argument[0]);
  int count = static_cast<int>(pointers.size());

  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 1;
  bs_car_odometry::benchmarks::RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.printRatio("fourWheelStep", {"mrptStep", "mrptStepNewAction"});
  for (const char* method : {"exactMomentsSensitivity", "exactMomentsDegreeFive", "closedForm"})
    reporter.printRatio(method, {"fourWheelStep"});
  reporter.printRatio("pipelineStepWithHistory", {"pipelineStep"});
  reporter.printRatio("particlesStep", {"numbersAlone"});
  return 0;
}
