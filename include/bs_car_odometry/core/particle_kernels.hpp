#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace bs_car_odometry {

/// Particles are worked on block by block, so that what passes between the kernels stays in the nearest
/// cache.
constexpr std::size_t kParticleBlock = 256;

using FloatBlock = std::array<float, kParticleBlock>;
using DoubleBlock = std::array<double, kParticleBlock>;
using BitBlock = std::array<std::uint32_t, kParticleBlock>;

struct MotionBlock {
  FloatBlock x, y, turn;
};

/// What the reference of the particles' poses does in one step.
struct ReferenceStep {
  double cosine, sine;  ///< of its yaw before the step
  double dx, dy, turn;  ///< [m, m, rad] in odom
};

/// Mean of (x, y, yaw), and sums of the products of the departures from it: xx, xy, xa, yy, ya, aa.
struct BlockMoments {
  std::array<double, 3> mean;
  std::array<double, 6> products;
};

/// Which random numbers: everything that tells one draw from another but the particle. The cloud therefore
/// depends on nothing but the seed and the readings: not on threads, blocks or the order of the work.
struct DrawNumber {
  std::uint64_t seed{0};
  std::uint32_t step{0};
  std::uint32_t purpose{0};
  std::uint16_t round{0};    ///< of several draws for one purpose in one step
  std::uint16_t attempt{0};  ///< of a draw that may be refused
};

using PhiloxCounter = std::array<std::uint32_t, 4>;
using PhiloxKey = std::array<std::uint32_t, 2>;

/// Philox4x32-10, the counter-based generator of Salmon et al., "Parallel random numbers: as easy as 1, 2,
/// 3", SC11: four numbers of 32 random bits for each counter.
PhiloxCounter philox(const PhiloxCounter& counter, const PhiloxKey& key);

/// The following kernels are plain loops that the compiler turns into vector instructions. Every operation is
/// rounded by itself, in the order written: the numbers are the same whatever the width of the vectors.
namespace kernels {

/// philox() of the counters (particles[i], step, purpose, round and attempt).
/// @param count  at most kParticleBlock
void randomBits(const DrawNumber& number, const std::uint32_t* particles, std::size_t count,
                std::array<BitBlock, 4>& bits);

/// Two independent standard normal numbers from two random ones, by Box and Muller; at most 6.7 in size.
void normals(const BitBlock& radius, const BitBlock& direction, std::size_t count, FloatBlock& first,
             FloatBlock& second);

/// The first of them alone.
void normals(const BitBlock& radius, const BitBlock& direction, std::size_t count, FloatBlock& first);

/// Numbers between -1 and 1, evenly.
void uniforms(const BitBlock& bits, std::size_t count, FloatBlock& values);

/// Sine and cosine of any angles up to 1e9 [rad], to 1e-7.
void sinesAndCosines(const DoubleBlock& angles, std::size_t count, FloatBlock& sines, FloatBlock& cosines);

/// t += M (a, b, c) for every particle. Body motions t = (ux, uy, dtheta) [m, m, rad].
/// @param M  row by row
void addProducts(const std::array<float, 9>& M, const float* a, const float* b, const float* c,
                 std::size_t count, MotionBlock& t);

/// t += C (a, a^2, b, b^2, ab).
/// @param C  row by row
void addPolynomials(const std::array<float, 15>& C, const FloatBlock& a, const FloatBlock& b,
                    std::size_t count, MotionBlock& t);

/// Heading of each particle's displacement, half of the step's turn added, less that of the reference.
void halfwayHeadings(const double* yaw, const FloatBlock& turn, std::size_t count, DoubleBlock& halfway);

/// Largest of |values[i]|.
float largestSize(const FloatBlock& values, std::size_t count);

/// sin(turn/2) / (turn/2), for turns of at most kLargeTurn.
void chords(const FloatBlock& turn, std::size_t count, FloatBlock& chord);
constexpr float kLargeTurn = 4.0F;  ///< [rad]

/// The same for any turns, at the price of a sine.
void chordsOfLargeTurns(const FloatBlock& turn, std::size_t count, FloatBlock& chord);

/// (M-exp) for every particle, whose pose is held as its departure from a reference that moves by
/// `reference`.
void move(const MotionBlock& t, const FloatBlock& chord, const FloatBlock& sines, const FloatBlock& cosines,
          const ReferenceStep& reference, std::size_t count, double* x, double* y, double* yaw);

/// Sums over a block: mean, and products about it.
BlockMoments moments(const double* x, const double* y, const double* yaw, std::size_t count);

}  // namespace kernels

}  // namespace bs_car_odometry
