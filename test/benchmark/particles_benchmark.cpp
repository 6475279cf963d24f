// A step of 100,000 particles against what it cannot do without: as many sines, cosines and normal numbers.
#include "drive.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <numeric>

namespace bs_car_odometry::benchmarks {
namespace {

constexpr std::size_t kParticles = 100000;

void particlesStep(benchmark::State& state) {
  const std::array<StepReadings, kSteps> drive = slalom();
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.options.uncertainty = Uncertainty::kMonteCarlo;
  configuration.options.particles.count = kParticles;
  OdometryEstimator estimator(configuration);
  std::size_t i = 0;
  for (auto _ : state) {
    estimator.step(drive[i++ % kSteps], durationFromSeconds(0.02));
    benchmark::DoNotOptimize(estimator);
  }
}

struct Numbers {
  BitBlock particles;
  std::array<BitBlock, 4> bits;
  std::array<FloatBlock, 3> normals;
  DoubleBlock angles;
  FloatBlock sines, cosines;
};

/// In a step of this drive a particle draws three numbers for wheels and side slip, and in one step out of
/// five one for each of two angles, whose errors last for 0.1 m of its 0.02 m steps.
void numbersOfBlock(std::uint32_t step, std::size_t count, Numbers& n) {
  kernels::randomBits({1, step, 0}, n.particles.data(), count, n.bits);
  kernels::normals(n.bits[0], n.bits[1], count, n.normals[0], n.normals[1]);
  kernels::normals(n.bits[2], n.bits[3], count, n.normals[2]);
  benchmark::DoNotOptimize(n.normals);
  for (std::uint32_t axle = 1; axle <= kAxles; ++axle) {
    kernels::randomBits({1, step, axle}, n.particles.data(), count / 5, n.bits);
    kernels::normals(n.bits[0], n.bits[1], count / 5, n.normals[0]);
    benchmark::DoNotOptimize(n.normals);
  }
  kernels::sinesAndCosines(n.angles, count, n.sines, n.cosines);
  benchmark::DoNotOptimize(n.sines);
  benchmark::DoNotOptimize(n.cosines);
}

void numbersAlone(benchmark::State& state) {
  const auto n = std::make_unique<Numbers>();
  std::iota(n->particles.begin(), n->particles.end(), 0U);
  for (std::size_t i = 0; i < kParticleBlock; ++i) n->angles[i] = 0.01 * static_cast<double>(i) - 1.3;
  std::uint32_t step = 0;
  for (auto _ : state) {
    ++step;
    for (std::size_t first = 0; first < kParticles; first += kParticleBlock)
      numbersOfBlock(step, std::min(kParticleBlock, kParticles - first), *n);
  }
}

BENCHMARK(particlesStep);
BENCHMARK(numbersAlone);

}  // namespace
}  // namespace bs_car_odometry::benchmarks
