#include "bs_car_odometry/ros/relative_motion.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <iomanip>
#include <sstream>

namespace bs_car_odometry {

namespace {

/// Every digit: stamps are copied from a refusal into the next request.
std::string text(Time time) {
  std::ostringstream text;
  text << toRos(time);
  return text.str();
}

std::string text(const TimeSpan& span) { return text(span.begin) + " to " + text(span.end); }

std::string whyNoSpan(const MotionHistory& history) {
  if (history.longest() <= Duration::zero()) return "relative_motion/history is 0: no motion is kept";
  return "no motion is known yet: the history begins with the first accepted wheel message after the start, "
         "~reset or a clock that went back, and spans something with the second";
}

std::string whyOutside(const char* name, Time stamp, const TimeSpan& span) {
  const std::string where = std::string(name) + " (" + text(stamp) + ") lies ";
  const std::string spans = " the history, which spans " + text(span);
  if (stamp < span.begin)
    return where + "before" + spans + ": relative_motion/history says how far back it goes, with at most " +
           std::to_string(MotionHistory::kMostSteps) + " steps";
  return where + "after" + spans + ": it is known once the wheel message after it has come";
}

std::string whyUnknown(const MotionHistory& history, Time from, Time to) {
  const std::optional<TimeSpan> span = history.span();
  if (!span) return whyNoSpan(history);
  if (!span->contains(from)) return whyOutside("from", from, *span);
  if (!span->contains(to)) return whyOutside("to", to, *span);
  return "the covariance is not finite: ask for a shorter interval";
}

/// Empty when all of it was seen.
std::string whatWasNotSeen(const MotionEstimate& motion) {
  if (motion.unseen <= Duration::zero()) return {};
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << "the motion was not seen for " << toSeconds(motion.unseen)
       << " s of it (counters restarted or a step refused): the covariance allows for max_speed";
  return text.str();
}

}  // namespace

void fillRelativeMotion(const MotionHistory& history, double unmeasured_variance,
                        const RelativeMotion::Request& request, RelativeMotion::Response& response) {
  response = RelativeMotion::Response();
  response.motion.pose.orientation.w = 1.0;
  const std::optional<Time> from = toTime(request.from);
  const std::optional<Time> to = toTime(request.to);
  if (!from || !to) {
    response.message = std::string(from ? "to" : "from") + " is no time: its nanoseconds are out of range";
    return;
  }
  const std::optional<MotionEstimate> motion = history.between(*from, *to);
  response.success = motion.has_value();
  if (!motion) {
    response.message = whyUnknown(history, *from, *to);
    return;
  }
  response.message = whatWasNotSeen(*motion);
  response.motion.pose.position.x = motion->motion.x;
  response.motion.pose.position.y = motion->motion.y;
  response.motion.pose.orientation = toQuaternion(motion->motion.yaw);
  response.motion.covariance = toCovariance(motion->covariance, unmeasured_variance);
  response.distance = motion->distance;
}

}  // namespace bs_car_odometry
