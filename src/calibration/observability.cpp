#include "bs_car_odometry/calibration/observability.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace bs_car_odometry::calibration {

namespace {

/// What shows a parameter.
enum class Manoeuvre { kStraight, kTurn, kChange };
constexpr std::array<Manoeuvre, 3> kAllManoeuvres{Manoeuvre::kStraight, Manoeuvre::kTurn, Manoeuvre::kChange};

/// Below this share of the information needed, what was driven says nothing about what is still to drive: an
/// extended Kalman filter learns a little from noise alone.
constexpr double kSmallShare = 0.1;

/// What to begin with [m], [degrees], the least that is worth saying, and the most that is asked for at once.
struct Amount {
  double first, least, most;
};
constexpr Amount kStraightAmount{5.0, 1.0, 50.0};
constexpr Amount kTurnAmount{90.0, 10.0, 360.0};

// Motion without which a small deviation is not believed.
constexpr double kLeastDistance = 2.0;         // [m]
constexpr double kLeastTurn = 0.5;             // [rad]
constexpr double kLeastSpeedChange = 0.5;      // [m/s]
constexpr double kLeastTurnRateChange = 0.25;  // [rad/s]

// A gain outside these means that something else is wrong.
constexpr double kLeastGain = 0.8;
constexpr double kLargestGain = 1.2;

constexpr double kDegrees = 180.0 / M_PI;

Manoeuvre manoeuvreFor(std::size_t parameter) {
  switch (parameter) {
    case kTimeOffset:
      return Manoeuvre::kChange;
    case systematic::kFrontTrack:
    case systematic::kRearTrack:
    case kFrontScale:
    case kRearScale:
    case kLaserX:
    case kLaserY:
      return Manoeuvre::kTurn;
    default:
      return Manoeuvre::kStraight;
  }
}

double turned(const Excitation& driven) { return driven.turned_left + driven.turned_right; }

/// Share of the information that makes a parameter observed. With a prior of variance p^2 and information I
/// the variance is 1/(1/p^2 + I), and a deviation of p/2 needs I = 3/p^2.
double informationShare(const Knowledge& knowledge, std::size_t parameter) {
  const auto k = static_cast<Eigen::Index>(parameter);
  const double ratio = knowledge.prior[k] / knowledge.deviation[k];
  return std::clamp((ratio * ratio - 1.0) / 3.0, 0.0, 1.0);
}

double motionShare(const Excitation& driven, Manoeuvre manoeuvre) {
  switch (manoeuvre) {
    case Manoeuvre::kStraight:
      return std::min(1.0, driven.distance / kLeastDistance);
    case Manoeuvre::kTurn:
      return std::min(1.0, turned(driven) / kLeastTurn);
    case Manoeuvre::kChange:
      return std::min(
          1.0, driven.speed_change / kLeastSpeedChange + driven.turn_rate_change / kLeastTurnRateChange);
  }
  return 0.0;
}

/// How much more of a manoeuvre: the information of a straight leg or a turn grows with its square.
double remaining(const Knowledge& knowledge, std::size_t parameter, double done, const Amount& amount) {
  const double share = informationShare(knowledge, parameter);
  const double more =
      share < kSmallShare ? std::max(amount.first - done, 0.0) : done * (1.0 / std::sqrt(share) - 1.0);
  return std::ceil(std::clamp(more, amount.least, amount.most) / amount.least) * amount.least;
}

std::string sentence(Manoeuvre manoeuvre, const Excitation& driven, double amount) {
  std::array<char, 64> text{};
  switch (manoeuvre) {
    case Manoeuvre::kStraight:
      std::snprintf(text.data(), text.size(), "drive %.0f m more straight ahead", amount);
      break;
    case Manoeuvre::kTurn:
      std::snprintf(text.data(), text.size(), "turn %.0f degrees more to the %s", amount,
                    driven.turned_left < driven.turned_right ? "left" : "right");
      break;
    case Manoeuvre::kChange:
      return "change speed";
  }
  return text.data();
}

/// One clause for those of the parameters in `which` that the manoeuvre shows; empty when there are none.
std::string clause(const Knowledge& knowledge, const ParameterMask& which, Manoeuvre manoeuvre) {
  const Excitation& driven = knowledge.excitation;
  const bool turn = manoeuvre == Manoeuvre::kTurn;
  const double done = turn ? kDegrees * turned(driven) : driven.straight;
  std::string names;
  double amount = 0.0;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!which[i] || manoeuvreFor(i) != manoeuvre) continue;
    names += (names.empty() ? "" : ", ") + parameterName(i);
    amount = std::max(amount, remaining(knowledge, i, done, turn ? kTurnAmount : kStraightAmount));
  }
  return names.empty() ? names : names + ": " + sentence(manoeuvre, driven, amount);
}

std::string clauses(const Knowledge& knowledge, const ParameterMask& which) {
  std::string text;
  for (const Manoeuvre manoeuvre : kAllManoeuvres) {
    const std::string next = clause(knowledge, which, manoeuvre);
    if (!next.empty()) text += (text.empty() ? "" : "; ") + next;
  }
  return text;
}

template <typename Condition>
ParameterMask maskWhere(const Condition& condition) {
  ParameterMask mask{};
  for (std::size_t i = 0; i < kCount; ++i) mask[i] = condition(i);
  return mask;
}

}  // namespace

Knowledge knowledgeOf(const Calibrator& calibrator) {
  return {calibrator.estimated(), calibrator.prior(),
          calibrator.estimate().covariance.diagonal().cwiseMax(0.0).cwiseSqrt(), calibrator.excitation()};
}

double progress(const Knowledge& knowledge, std::size_t parameter) {
  if (!knowledge.estimated[parameter]) return 1.0;
  return std::min(informationShare(knowledge, parameter),
                  motionShare(knowledge.excitation, manoeuvreFor(parameter)));
}

std::string missing(const Knowledge& knowledge) {
  return clauses(knowledge,
                 maskWhere([&](std::size_t i) { return knowledge.estimated[i] && !knowledge.observed(i); }));
}

std::string whyNotAllObserved(const Knowledge& knowledge) {
  const std::string text = clauses(knowledge, maskWhere([&](std::size_t i) {
                                     return isGain(i) && knowledge.estimated[i] && !knowledge.observed(i);
                                   }));
  return text.empty() ? text : "not observed yet: " + text;
}

std::string implausibleGains(const ParameterVector& values, const ParameterMask& observed) {
  std::string names;
  bool wheel = false;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double value = values[static_cast<Eigen::Index>(i)];
    if (!isGain(i) || !observed[i] || (value >= kLeastGain && value <= kLargestGain)) continue;
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%s = %.3g", parameterName(i).c_str(), value);
    names += (names.empty() ? "" : ", ") + std::string(text.data());
    wheel = wheel || manoeuvreFor(i) == Manoeuvre::kStraight;
  }
  if (names.empty()) return names;
  return names + ": outside 0.8 to 1.2; check " +
         (wheel ? "the wheels' radius and the encoders' ticks per turn (encoders/metres_per_tick), and the "
                  "units of the laser poses"
                : "vehicle/track and its unit, and that steering angles are in radians");
}

}  // namespace bs_car_odometry::calibration
