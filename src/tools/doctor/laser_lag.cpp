#include "laser_lag.hpp"

#include "motion_windows.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr double kSpan = 0.5;      // [s] over which motions are compared
constexpr double kFurthest = 1.0;  // [s]
constexpr double kCoarse = 0.025;  // [s]
constexpr double kFine = 0.0005;   // [s]
constexpr double kShift = 0.1;     // [s], over which the wheels' speeds are differenced
constexpr double kStill = 0.02;    // [m/s]
constexpr double kLongestSigma = 0.1;
constexpr std::size_t kMostPairs = 6000;
constexpr std::size_t kFewestPairs = 20;
constexpr double kOutlier = 6.0;  ///< times the median residual
/// Residuals that the fit may leave without being believed to be more exact [rad], [m].
constexpr double kFloorTurn = 2e-4;
constexpr double kFloorWay = 1e-3;

/// What the laser saw between two poses.
struct Pair {
  double begin, end;      ///< [s]
  Eigen::Vector2d moved;  ///< turn [rad], way along the mean heading [m]
};

using Wheels = Eigen::Vector4d;

/// From, from + step, ... as far as to.
std::vector<double> lagsBetween(double from, double to, double step) {
  constexpr double kRounding = 1e-9;
  std::vector<double> lags(static_cast<std::size_t>(std::max((to - from) / step + kRounding, 0.0)) + 1);
  for (std::size_t i = 0; i < lags.size(); ++i) lags[i] = from + static_cast<double>(i) * step;
  return lags;
}

Pair pairOf(const LaserSample& a, const LaserSample& b) {
  const double heading = 0.5 * (a.base.yaw + b.base.yaw);
  const Eigen::Vector2d way = b.base.position() - a.base.position();
  return {a.t, b.t, {b.base.yaw - a.base.yaw, std::cos(heading) * way.x() + std::sin(heading) * way.y()}};
}

bool standsBetween(const WheelSample& a, const WheelSample& b) {
  return std::all_of(kAllWheels.begin(), kAllWheels.end(), [&](Wheel wheel) {
    return std::abs(b.travel[wheel] - a.travel[wheel]) <= kStill * (b.t - a.t);
  });
}

/// Times [s] at which wheels are known, whatever the lag: a car that stands at the beginning or the end of
/// the record stood before and after.
std::pair<double, double> knownTimes(const std::vector<WheelSample>& wheels) {
  const std::size_t n = wheels.size();
  const double before = standsBetween(wheels[0], wheels[1]) ? 0.0 : kFurthest + kShift;
  const double after = standsBetween(wheels[n - 2], wheels[n - 1]) ? 0.0 : kFurthest + kShift;
  return {wheels.front().t + before, wheels.back().t - after};
}

std::vector<Pair> pairsOf(const DriveRecord& record) {
  const std::vector<LaserSample>& laser = record.laser.samples();
  if (record.wheels.samples().size() < 2) return {};
  const auto [earliest, latest] = knownTimes(record.wheels.samples());
  std::vector<Pair> pairs;
  std::size_t to = 0;
  for (std::size_t from = 0; from < laser.size(); ++from) {
    while (to < laser.size() && laser[to].t < laser[from].t + kSpan - 1e-3) ++to;
    if (to == laser.size()) break;
    if (laser[from].t >= earliest && laser[to].t <= latest && laser[to].t < laser[from].t + 2.0 * kSpan)
      pairs.push_back(pairOf(laser[from], laser[to]));
  }
  return pairs;
}

class LagFit {
 public:
  explicit LagFit(const DriveRecord& record) : record_(record), pairs_(pairsOf(record)) {
    // Neighbours share most of their interval, and say little that is new.
    if (pairs_.size() > 1)
      overlap_ = std::min(1.0, (pairs_[1].begin - pairs_[0].begin) / (pairs_[0].end - pairs_[0].begin));
    const std::size_t stride = pairs_.size() / kMostPairs + 1;
    if (stride > 1) {
      std::vector<Pair> some;
      for (std::size_t i = 0; i < pairs_.size(); i += stride) some.push_back(pairs_[i]);
      pairs_ = some;
      overlap_ = std::min(1.0, overlap_ * static_cast<double>(stride));
    }
  }

  std::size_t pairs() const { return pairs_.size(); }

  /// Minus the logarithm of the likelihood, but for a constant.
  double cost(double lag) const {
    return 0.5 * static_cast<double>(pairs_.size()) * overlap_ * variances(lag).log().sum();
  }

  /// Standard deviation of the lag: from how far the motion that the wheels explain moves with it.
  double sigma(double lag) const {
    const Eigen::MatrixX4d X = travels(lag);
    const Eigen::MatrixX4d slope = (travels(lag + kShift) - travels(lag - kShift)) / (2.0 * kShift);
    const Eigen::MatrixX2d moves = slope * factors(X, moved());
    const Eigen::MatrixX2d alone = moves - X * factors(X, moves);
    const Eigen::Array2d information = alone.colwise().squaredNorm().transpose().array() / variances(lag);
    return 1.0 / std::sqrt(overlap_ * information.sum() + 1e-9);
  }

  /// Standard deviation over all lags that are tried, by how likely each is: large where another one is as
  /// good.
  double spread(double lag) const {
    double weight = 0.0, square = 0.0;
    const double least = cost(lag);
    for (const double other : lagsBetween(-kFurthest, kFurthest, kCoarse)) {
      const double likely = std::exp(least - cost(other));
      weight += likely;
      square += likely * (other - lag) * (other - lag);
    }
    return std::sqrt(square / std::max(weight, 1e-9));
  }

  double best() const {
    double lag = best(0.0, kFurthest, kCoarse);
    lag = best(lag, kCoarse, kCoarse / 5.0);
    return best(lag, kCoarse / 5.0, kFine);
  }

  /// Leaves out what a localiser that jumps has added.
  void dropOutliers(double lag) {
    const Eigen::MatrixX2d left = residuals(lag).cwiseAbs();
    Eigen::Array2d limit;
    for (Eigen::Index c = 0; c < 2; ++c) {
      EvenSample sizes;
      for (Eigen::Index i = 0; i < left.rows(); ++i) sizes.add(left(i, c));
      limit[c] = kOutlier * sizes.quantile(0.5) + (c == 0 ? kFloorTurn : kFloorWay);
    }
    std::vector<Pair> kept;
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      if ((left.row(static_cast<Eigen::Index>(i)).transpose().array() <= limit).all())
        kept.push_back(pairs_[i]);
    pairs_ = kept;
  }

 private:
  /// Mean squares of what the fit leaves of turn [rad^2] and way [m^2].
  Eigen::Array2d variances(double lag) const {
    const Eigen::Array2d floor(kFloorTurn, kFloorWay);
    const double n = static_cast<double>(pairs_.size());
    return residuals(lag).colwise().squaredNorm().transpose().array() / n + floor.square();
  }

  double best(double around, double reach, double step) const {
    double best_lag = around;
    double best_cost = cost(around);
    const double first = std::max(around - reach, -kFurthest);
    for (const double lag : lagsBetween(first, std::min(around + reach, kFurthest), step)) {
      const double c = cost(lag);
      if (c >= best_cost) continue;
      best_cost = c;
      best_lag = lag;
    }
    return best_lag;
  }

  Eigen::MatrixX4d travels(double lag) const {
    const std::vector<WheelSample>& wheels = record_.wheels.samples();
    const auto known = [&](double t) {
      return std::clamp(t, wheels.front().t, wheels.back().t - 1e-9 * std::abs(wheels.back().t) - 1e-9);
    };
    Eigen::MatrixX4d X = Eigen::MatrixX4d::Zero(static_cast<Eigen::Index>(pairs_.size()), 4);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      PerWheel<double> travel;
      if (travelBetween(record_, known(pairs_[i].begin - lag), known(pairs_[i].end - lag), travel))
        X.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVector4d>(travel.values.data());
    }
    return X;
  }

  Eigen::MatrixX2d moved() const {
    Eigen::MatrixX2d Y(static_cast<Eigen::Index>(pairs_.size()), 2);
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      Y.row(static_cast<Eigen::Index>(i)) = pairs_[i].moved.transpose();
    return Y;
  }

  /// Factors of the wheels by which their travels explain Y best.
  static Eigen::Matrix<double, 4, 2> factors(const Eigen::MatrixX4d& X, const Eigen::MatrixX2d& Y) {
    Eigen::Matrix4d normal = X.transpose() * X;
    // Wheels that always roll alike, or not at all, leave a direction open.
    normal.diagonal().array() += 1e-7 * normal.trace() + 1e-12;
    return normal.ldlt().solve(X.transpose() * Y);
  }

  Eigen::MatrixX2d residuals(double lag) const {
    const Eigen::MatrixX4d X = travels(lag);
    const Eigen::MatrixX2d Y = moved();
    return Y - X * factors(X, Y);
  }

  const DriveRecord& record_;
  std::vector<Pair> pairs_;
  double overlap_{1.0};
};

}  // namespace

std::optional<LaserLag> estimateLaserLag(const DriveRecord& record) {
  LagFit fit(record);
  if (fit.pairs() < kFewestPairs) return std::nullopt;
  fit.dropOutliers(fit.best());
  if (fit.pairs() < kFewestPairs) return std::nullopt;
  const double lag = fit.best();
  const double sigma = fit.sigma(lag);
  if (sigma > kLongestSigma || fit.spread(lag) > kLongestSigma || std::abs(lag) > kFurthest - kCoarse)
    return std::nullopt;
  return LaserLag{lag, sigma};
}

}  // namespace bs_car_odometry::tools::doctor
