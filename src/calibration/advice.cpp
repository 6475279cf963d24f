#include "bs_car_odometry/calibration/advice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

namespace bs_car_odometry::calibration {

namespace {

/// What shows a parameter.
enum class Motion { kDistance, kTurn, kSpeed };

Motion motionFor(std::size_t parameter) {
  switch (parameter) {
    case systematic::kFrontTrack:
    case systematic::kRearTrack:
    case kFrontScale:
    case kRearScale:
    case kLaserX:
    case kLaserY:
      return Motion::kTurn;
    case kTimeOffset:
      return Motion::kSpeed;
    default:
      return Motion::kDistance;
  }
}

/// What is asked of a drive that has shown nothing yet, and the most that is asked at once.
constexpr double kFirstDistance = 20.0;     // m
constexpr double kLargestDistance = 500.0;  // m
constexpr double kFirstTurn = 180.0;        // degrees
constexpr double kLargestTurn = 360.0;      // degrees

/// Below it the pace says nothing: an extended Kalman filter learns a little from noise alone.
constexpr double kLeastInformation = 0.3;

/// How much more of a motion is needed. Information 1/sigma^2 - 1/prior^2 grows with the motion, and
/// 3/prior^2 of it halves the prior.
double remaining(double so_far, double deviation, double prior, double first, double largest) {
  const double information = prior * prior / (deviation * deviation) - 1.0;
  if (!(information > kLeastInformation) || !(so_far > 0.0)) return first;
  return std::clamp(so_far * (3.0 / information - 1.0), 0.0, largest);
}

double roundedUp(double value, double unit) { return std::max(unit, unit * std::ceil(value / unit)); }

std::string sentence(Motion motion, double amount, const Excitation& driven) {
  std::array<char, 80> text{};
  if (motion == Motion::kSpeed) return "drive on, and stop and start again several times";
  if (motion == Motion::kDistance)
    std::snprintf(text.data(), text.size(), "drive %.0f m more", roundedUp(amount, 5.0));
  else
    std::snprintf(text.data(), text.size(), "turn %.0f degrees more to the %s", roundedUp(amount, 10.0),
                  driven.turned_left <= driven.turned_right ? "left" : "right");
  return text.data();
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

std::string whatToDrive(const ParameterMask& missing, const FilterEstimate& estimate,
                        const ParameterVector& prior, const Excitation& excitation) {
  struct Need {
    std::vector<std::string> parameters;
    double amount{0.0};
  };
  std::map<Motion, Need> needs;
  const double turned = (excitation.turned_left + excitation.turned_right) * 180.0 / M_PI;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!missing[i]) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const double deviation = std::sqrt(estimate.covariance(k, k));
    const Motion motion = motionFor(i);
    const double amount =
        motion == Motion::kTurn
            ? remaining(turned, deviation, prior[k], kFirstTurn, kLargestTurn)
            : remaining(excitation.distance, deviation, prior[k], kFirstDistance, kLargestDistance);
    needs[motion].parameters.push_back(parameterName(i));
    needs[motion].amount = std::max(needs[motion].amount, amount);
  }
  std::string text;
  for (const auto& [motion, need] : needs)
    text += (text.empty() ? "" : "; ") + joined(need.parameters) + ": " +
            sentence(motion, need.amount, excitation);
  return text;
}

std::string implausibleGains(const ParameterVector& values, const ParameterMask& estimated) {
  std::vector<std::string> out;
  bool wheel = false;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double value = values[static_cast<Eigen::Index>(i)];
    if (!isGain(i) || !estimated[i] || (value >= kLeastPlausibleGain && value <= kLargestPlausibleGain))
      continue;
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%s = %.3g", parameterName(i).c_str(), value);
    out.emplace_back(text.data());
    wheel = wheel || (i != systematic::kFrontTrack && i != systematic::kRearTrack);
  }
  if (out.empty()) return {};
  return joined(out) + ": outside 0.8 to 1.2; check " +
         (wheel ? "the wheels' radius and the encoders' ticks per turn (encoders/metres_per_tick), and the "
                  "units of "
                  "the laser poses"
                : "vehicle/track and its unit, and that steering angles are in radians");
}

}  // namespace bs_car_odometry::calibration
