// Compiled with options of its own (CMakeLists.txt) that let loops over square roots and selections become
// vector code; none of them changes a result.
#include "bs_car_odometry/core/particle_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace bs_car_odometry {

namespace {

constexpr std::uint32_t kMultiplier0 = 0xD2511F53u;
constexpr std::uint32_t kMultiplier1 = 0xCD9E8D57u;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9u;
constexpr std::uint32_t kWeyl1 = 0xBB67AE85u;

inline std::uint32_t high(std::uint64_t product) { return static_cast<std::uint32_t>(product >> 32); }
inline std::uint32_t low(std::uint64_t product) { return static_cast<std::uint32_t>(product); }

struct PhiloxState {
  std::uint32_t c0, c1, c2, c3;

  inline void round(std::uint32_t k0, std::uint32_t k1) {
    const std::uint64_t p0 = std::uint64_t{kMultiplier0} * c0;
    const std::uint64_t p1 = std::uint64_t{kMultiplier1} * c2;
    c0 = high(p1) ^ c1 ^ k0;
    c2 = high(p0) ^ c3 ^ k1;
    c1 = low(p1);
    c3 = low(p0);
  }

  /// All ten, written out: a loop in here would keep the one over the particles from being vectorised.
  inline void tenRounds(std::uint32_t k0, std::uint32_t k1) {
    round(k0, k1);
    round(k0 + 1 * kWeyl0, k1 + 1 * kWeyl1);
    round(k0 + 2 * kWeyl0, k1 + 2 * kWeyl1);
    round(k0 + 3 * kWeyl0, k1 + 3 * kWeyl1);
    round(k0 + 4 * kWeyl0, k1 + 4 * kWeyl1);
    round(k0 + 5 * kWeyl0, k1 + 5 * kWeyl1);
    round(k0 + 6 * kWeyl0, k1 + 6 * kWeyl1);
    round(k0 + 7 * kWeyl0, k1 + 7 * kWeyl1);
    round(k0 + 8 * kWeyl0, k1 + 8 * kWeyl1);
    round(k0 + 9 * kWeyl0, k1 + 9 * kWeyl1);
  }
};

template <typename To, typename From>
inline To bitsAs(From value) {
  static_assert(sizeof(To) == sizeof(From));
  To result;
  std::memcpy(&result, &value, sizeof(To));
  return result;
}

/// Logarithm of a positive normal number, relative error 1e-7 (polynomial of the Cephes library).
inline float logarithm(float x) {
  constexpr std::int32_t kRootHalf = 0x3f3504f3;  // the mantissa is taken from 1/sqrt(2) to sqrt(2)
  const std::int32_t offset = bitsAs<std::int32_t>(x) - kRootHalf;
  const auto exponent = static_cast<float>(offset >> 23);
  const float f = bitsAs<float>((offset & 0x7fffff) + kRootHalf) - 1.0F;
  const float f2 = f * f;
  float y = 7.0376836292e-2F;
  y = y * f - 1.1514610310e-1F;
  y = y * f + 1.1676998740e-1F;
  y = y * f - 1.2420140846e-1F;
  y = y * f + 1.4249322787e-1F;
  y = y * f - 1.6668057665e-1F;
  y = y * f + 2.0000714765e-1F;
  y = y * f - 2.4999993993e-1F;
  y = y * f + 3.3333331174e-1F;
  y = f * f2 * y - 0.5F * f2;
  return exponent * 0.69314718056F + (f + y);
}

struct SineCosine {
  float sine;
  float cosine;
};

/// Of quadrant * pi/2 + x, |x| <= pi/4 (polynomials of the Cephes library).
inline SineCosine sineCosine(std::int32_t quadrant, float x) {
  const float x2 = x * x;
  const float s = ((-1.9515295891e-4F * x2 + 8.3321608736e-3F) * x2 - 1.6666654611e-1F) * x2 * x + x;
  const float c =
      ((2.443315711809948e-5F * x2 - 1.388731625493765e-3F) * x2 + 4.166664568298827e-2F) * x2 * x2 -
      0.5F * x2 + 1.0F;
  // An odd quadrant exchanges the two, the upper half circles turn their signs.
  const std::int32_t exchange = -(quadrant & 1);
  const auto s_bits = bitsAs<std::int32_t>(s);
  const auto c_bits = bitsAs<std::int32_t>(c);
  const std::int32_t difference = (s_bits ^ c_bits) & exchange;
  const auto q = static_cast<std::uint32_t>(quadrant);
  const std::uint32_t sine_sign = (q & 2u) << 30;
  const std::uint32_t cosine_sign = ((q + 1u) & 2u) << 30;
  return {bitsAs<float>(static_cast<std::uint32_t>(s_bits ^ difference) ^ sine_sign),
          bitsAs<float>(static_cast<std::uint32_t>(c_bits ^ difference) ^ cosine_sign)};
}

/// Of an angle of which 2^32 make a full circle.
inline SineCosine sineCosineOfCircle(std::uint32_t fraction) {
  const std::uint32_t rounded = fraction + (1u << 29);
  const auto rest = static_cast<std::int32_t>((rounded & 0x3fffffffu)) - (1 << 29);
  constexpr float kUnit = 1.5707963267948966F / 1073741824.0F;
  return sineCosine(static_cast<std::int32_t>(rounded >> 30), static_cast<float>(rest) * kUnit);
}

/// Radius of Box and Muller, of a number between 0 (not included) and 1.
inline float normalRadius(std::uint32_t bits) {
  const float u = static_cast<float>(static_cast<std::int32_t>(bits >> 1)) * 0x1p-31F + 0x1p-32F;
  return std::sqrt(-2.0F * logarithm(u));
}

}  // namespace

PhiloxCounter philox(const PhiloxCounter& counter, const PhiloxKey& key) {
  PhiloxState state{counter[0], counter[1], counter[2], counter[3]};
  state.tenRounds(key[0], key[1]);
  return {state.c0, state.c1, state.c2, state.c3};
}

namespace kernels {

void randomBits(const DrawNumber& number, const std::uint32_t* particles, std::size_t count,
                std::array<BitBlock, 4>& bits) {
  const DrawNumber n = number;
  const std::uint32_t k0 = low(n.seed);
  const std::uint32_t k1 = high(n.seed);
  const std::uint32_t repetition = (std::uint32_t{n.round} << 16) + n.attempt;
  for (std::size_t i = 0; i < count; ++i) {
    PhiloxState state{particles[i], n.step, n.purpose, repetition};
    state.tenRounds(k0, k1);
    bits[0][i] = state.c0;
    bits[1][i] = state.c1;
    bits[2][i] = state.c2;
    bits[3][i] = state.c3;
  }
}

void normals(const BitBlock& radius, const BitBlock& direction, std::size_t count, FloatBlock& first,
             FloatBlock& second) {
  for (std::size_t i = 0; i < count; ++i) {
    const float r = normalRadius(radius[i]);
    const SineCosine unit = sineCosineOfCircle(direction[i]);
    first[i] = r * unit.cosine;
    second[i] = r * unit.sine;
  }
}

void normals(const BitBlock& radius, const BitBlock& direction, std::size_t count, FloatBlock& first) {
  for (std::size_t i = 0; i < count; ++i)
    first[i] = normalRadius(radius[i]) * sineCosineOfCircle(direction[i]).cosine;
}

void uniforms(const BitBlock& bits, std::size_t count, FloatBlock& values) {
  for (std::size_t i = 0; i < count; ++i)
    values[i] = static_cast<float>(static_cast<std::int32_t>(bits[i])) * 0x1p-31F + 0x1p-32F;
}

void sinesAndCosines(const DoubleBlock& angles, std::size_t count, FloatBlock& sines, FloatBlock& cosines) {
  constexpr double kQuarter = 1.5707963267948966;
  constexpr double kRound = 0x1.8p52;  // adding it leaves the nearest integer in the low bits
  for (std::size_t i = 0; i < count; ++i) {
    const double shifted = angles[i] * (1.0 / kQuarter) + kRound;
    const auto quadrant = static_cast<std::int32_t>(bitsAs<std::int64_t>(shifted));
    const double rest = std::clamp(angles[i] - (shifted - kRound) * kQuarter, -1.0, 1.0);
    const SineCosine result = sineCosine(quadrant, static_cast<float>(rest));
    sines[i] = result.sine;
    cosines[i] = result.cosine;
  }
}

void addProducts(const std::array<float, 9>& M, const float* a, const float* b, const float* c,
                 std::size_t count, MotionBlock& t) {
  const std::array<float, 9> m = M;
  for (std::size_t i = 0; i < count; ++i) {
    t.x[i] += m[0] * a[i] + m[1] * b[i] + m[2] * c[i];
    t.y[i] += m[3] * a[i] + m[4] * b[i] + m[5] * c[i];
    t.turn[i] += m[6] * a[i] + m[7] * b[i] + m[8] * c[i];
  }
}

void addPolynomials(const std::array<float, 15>& C, const FloatBlock& a, const FloatBlock& b,
                    std::size_t count, MotionBlock& t) {
  const std::array<float, 15> c = C;
  for (std::size_t i = 0; i < count; ++i) {
    const float aa = a[i] * a[i];
    const float bb = b[i] * b[i];
    const float ab = a[i] * b[i];
    t.x[i] += c[0] * a[i] + c[1] * aa + c[2] * b[i] + c[3] * bb + c[4] * ab;
    t.y[i] += c[5] * a[i] + c[6] * aa + c[7] * b[i] + c[8] * bb + c[9] * ab;
    t.turn[i] += c[10] * a[i] + c[11] * aa + c[12] * b[i] + c[13] * bb + c[14] * ab;
  }
}

void halfwayHeadings(const double* yaw, const FloatBlock& turn, std::size_t count, DoubleBlock& halfway) {
  for (std::size_t i = 0; i < count; ++i) halfway[i] = yaw[i] + 0.5 * static_cast<double>(turn[i]);
}

void chords(const FloatBlock& turn, std::size_t count, FloatBlock& chord) {
  for (std::size_t i = 0; i < count; ++i) {
    const float u2 = 0.25F * turn[i] * turn[i];
    const float tail = 1.0F - u2 * (1.0F / 110.0F) * (1.0F - u2 * (1.0F / 156.0F));
    chord[i] = 1.0F - u2 * (1.0F / 6.0F) *
                          (1.0F - u2 * (1.0F / 20.0F) *
                                      (1.0F - u2 * (1.0F / 42.0F) * (1.0F - u2 * (1.0F / 72.0F) * tail)));
  }
}

float largestSize(const FloatBlock& values, std::size_t count) {
  // As whole numbers the bits of positive ones are in the same order.
  std::int32_t largest = 0;
  for (std::size_t i = 0; i < count; ++i)
    largest = std::max(largest, bitsAs<std::int32_t>(values[i]) & 0x7fffffff);
  return bitsAs<float>(largest);
}

void chordsOfLargeTurns(const FloatBlock& turn, std::size_t count, FloatBlock& chord) {
  DoubleBlock halves{};
  FloatBlock cosines;
  for (std::size_t i = 0; i < count; ++i) halves[i] = 0.5 * static_cast<double>(turn[i]);
  sinesAndCosines(halves, count, chord, cosines);
  for (std::size_t i = 0; i < count; ++i)
    chord[i] = std::abs(turn[i]) > 1e-3F ? 2.0F * chord[i] / turn[i] : 1.0F;
}

void move(const MotionBlock& t, const FloatBlock& chord, const FloatBlock& sines, const FloatBlock& cosines,
          const ReferenceStep& reference, std::size_t count, double* x, double* y, double* yaw) {
  const ReferenceStep r = reference;
  for (std::size_t i = 0; i < count; ++i) {
    const double along = chord[i] * (cosines[i] * t.x[i] - sines[i] * t.y[i]);
    const double across = chord[i] * (sines[i] * t.x[i] + cosines[i] * t.y[i]);
    x[i] += r.cosine * along - r.sine * across - r.dx;
    y[i] += r.sine * along + r.cosine * across - r.dy;
    yaw[i] += t.turn[i] - r.turn;
  }
}

namespace {

/// Sums are kept in so many parts, which vector code adds to side by side.
constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;

double sum(const Lanes& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

double mean(const double* values, std::size_t count) {
  Lanes lanes{};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) lanes[k] += values[i + k];
  for (; i < count; ++i) lanes[i % kLanes] += values[i];
  return sum(lanes) / static_cast<double>(count);
}

/// Sum of the products of departures from the means.
double product(const double* a, double a_mean, const double* b, double b_mean, std::size_t count) {
  Lanes lanes{};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) lanes[k] += (a[i + k] - a_mean) * (b[i + k] - b_mean);
  for (; i < count; ++i) lanes[i % kLanes] += (a[i] - a_mean) * (b[i] - b_mean);
  return sum(lanes);
}

}  // namespace

BlockMoments moments(const double* x, const double* y, const double* yaw, std::size_t count) {
  const double mx = mean(x, count);
  const double my = mean(y, count);
  const double ma = mean(yaw, count);
  return {{mx, my, ma},
          {product(x, mx, x, mx, count), product(x, mx, y, my, count), product(x, mx, yaw, ma, count),
           product(y, my, y, my, count), product(y, my, yaw, ma, count), product(yaw, ma, yaw, ma, count)}};
}

}  // namespace kernels

}  // namespace bs_car_odometry
