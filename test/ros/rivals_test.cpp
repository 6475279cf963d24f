// Others who publish what the odometry hears (E10) or what it publishes itself (O8).

#include "child_process.hpp"
#include "odometry_client.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace bs_car_odometry::testing {
namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

std::vector<std::string> companion(const std::string& role, const std::string& name) {
  return {BS_CAR_ODOMETRY_COMPANION, role, "__name:=" + name};
}

class Rivals : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(client_.connect()); }
  void TearDown() override { EXPECT_TRUE(client_.processLives()) << "invariant 5"; }

  /// 10 mm straight ahead.
  std::optional<nav_msgs::Odometry> ahead() {
    ticks_ += 100;
    return client_.step({ticks_, ticks_, ticks_, ticks_});
  }

  OdometryClient client_{"", "/odometry"};
  DiagnosticsListener diagnostics_;
  LogListener log_;
  std::int64_t ticks_{0};
};

TEST_F(Rivals, E10_the_first_publisher_is_kept) {
  ASSERT_TRUE(client_.reset());
  const auto first = ahead();
  ASSERT_TRUE(first);
  std::optional<nav_msgs::Odometry> last;
  {
    const ChildProcess rival(companion("driver", "rival"));
    // Each step as long as it takes, but nothing of the rival: it turns, and has other counters.
    ASSERT_TRUE(waitFor([&] {
      last = ahead();
      return last && client_.status().dropped_rival_publisher > 100;
    })) << rival.output();
    EXPECT_NEAR(last->pose.pose.position.x - first->pose.pose.position.x,
                1e-4 * static_cast<double>(ticks_ - 100), 1e-9);
    EXPECT_EQ(last->pose.pose.position.y, first->pose.pose.position.y);
    EXPECT_EQ(client_.status().counter_restarts, 0u);
    recordFigure("beside a rival at 100 Hz the pose is exact to %g m", 1e-9);
    EXPECT_TRUE(diagnostics_.waitForStatus("bs_car_odometry: Encoders", Level::ERROR,
                                           "another node publishes on this input"));
    EXPECT_TRUE(log_.waitForLine("another node publishes on this input", rosgraph_msgs::Log::ERROR));
    EXPECT_LE(log_.count("another node publishes on this input", rosgraph_msgs::Log::ERROR),
              1 + static_cast<std::size_t>((last->header.stamp - first->header.stamp).toSec() / 5.0));

    // The first driver falls silent: after a second the other one is heard.
    client_.announceJump();
    const std::size_t before = client_.odometry().size();
    EXPECT_TRUE(waitFor([&] {
      client_.announceJump();
      return client_.odometry().size() > before + 20;
    }));
  }
  // The rival has ended, without a word to anybody in the other order: the first one comes back.
  client_.announceJump();
  ASSERT_TRUE(waitFor([&] {
    client_.announceJump();
    return ahead().has_value();
  }));
  const auto from = ahead();
  const auto to = ahead();
  ASSERT_TRUE(from && to);
  EXPECT_NEAR(std::hypot(to->pose.pose.position.x - from->pose.pose.position.x,
                         to->pose.pose.position.y - from->pose.pose.position.y),
              0.01, 1e-5)
      << "a thousandth: the rival's wheels contradicted its angle, and sensors may still be doubted";
}

TEST_F(Rivals, O8_a_foreign_transform_of_the_base_is_warned_of) {
  ASSERT_TRUE(client_.reset());
  ASSERT_TRUE(ahead());
  EXPECT_EQ(log_.count("on /tf, too", rosgraph_msgs::Log::WARN), 0u) << "its own is none";
  const ChildProcess rival(companion("transform", "rival_tf"));
  const std::string text =
      "/rival_tf publishes 'map' -> 'base_link' on /tf, too: stop it, or set 'publish_tf";
  EXPECT_TRUE(diagnostics_.waitForStatus("bs_car_odometry: Output", Level::WARN, text)) << rival.output();
  EXPECT_TRUE(log_.waitForLine(text, rosgraph_msgs::Log::WARN));
  EXPECT_EQ(log_.count(text, rosgraph_msgs::Log::WARN), 1u) << "a hundred a second, one line in 5 s";
  ASSERT_TRUE(ahead());
}

// Readings in degrees of a driver that was set up wrongly.
TEST_F(Rivals, S3_degrees_as_radians_are_hinted_at_within_a_second) {
  ASSERT_TRUE(client_.reset());
  ASSERT_TRUE(ahead());
  ASSERT_TRUE(waitFor([&] { return log_.connected(); }));
  const ros::SteadyTime begin = ros::SteadyTime::now();
  client_.send(steeringAngle(20.0, ros::Time::now()));
  EXPECT_TRUE(log_.waitForLine("if it were in degrees", rosgraph_msgs::Log::WARN, 1.0));
  recordFigure("the hint comes within %g s",
               roundedUp(std::max((ros::SteadyTime::now() - begin).toSec(), 0.01)));
  EXPECT_TRUE(diagnostics_.waitForStatus("bs_car_odometry: Steering", Level::WARN, "if it were in degrees"));
}

TEST_F(Rivals, S4_a_silent_steering_is_a_warning_first_and_an_error_after_a_second) {
  ASSERT_TRUE(client_.reset());
  ASSERT_TRUE(ahead());
  ASSERT_TRUE(waitFor([&] { return log_.connected(); }));
  const std::size_t before = client_.odometry().size();
  const auto wheelsOnly = [&] {
    ticks_ += 10;
    client_.send(wheelTicks({ticks_, ticks_, ticks_, ticks_}, ros::Time::now()));
    return false;
  };
  // waitFor() calls it every 10 ms at most.
  waitFor(wheelsOnly, 0.9);
  EXPECT_GT(client_.odometry().size(), before) << "the angle is held";
  EXPECT_EQ(client_.status().state, OdometryStatus::NO_STEERING);
  EXPECT_TRUE(log_.waitForLine("older than 'max_steering_age'", rosgraph_msgs::Log::WARN, 1.0));
  EXPECT_TRUE(waitFor(
      [&] {
        wheelsOnly();
        return diagnostics_.has("bs_car_odometry: Steering", Level::ERROR, "older than 'max_steering_age'");
      },
      5.0));
  EXPECT_GT(client_.status().steering_age[0], 1.0);
  EXPECT_TRUE(ahead());
  EXPECT_TRUE(ahead());
  EXPECT_EQ(client_.status().state, OdometryStatus::NOMINAL) << "recovery in two messages";
}

// The driver falls silent: a car that is not heard of does not stand still for that.
TEST_F(Rivals, O10_when_the_inputs_stop_so_does_the_output_and_an_error_says_so) {
  ASSERT_TRUE(client_.reset());
  ASSERT_TRUE(waitFor([&] { return ahead() && !client_.transforms().empty(); })) << "/tf is heard, too";
  const ros::SteadyTime begin = ros::SteadyTime::now();
  const std::size_t published = client_.odometry().size();
  ASSERT_TRUE(waitFor([&] {  // another topic, so perhaps a little later
    return client_.transforms().back().header.stamp == client_.odometry().back().header.stamp;
  }));
  const std::size_t transforms = client_.transforms().size();
  // Not what the silence before this test made it say.
  DiagnosticsListener diagnostics;
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Encoders", Level::ERROR, "no wheel message for"));
  const double seconds = (ros::SteadyTime::now() - begin).toSec();
  // Half a second of silence, less what the message was under way, which a report of every second says.
  EXPECT_GT(seconds, 0.4);
  EXPECT_EQ(client_.odometry().size(), published) << "no invented standstill";
  EXPECT_EQ(client_.transforms().size(), transforms);
  ASSERT_TRUE(ahead()) << "and it goes on";
  recordFigure("0 messages in the silence, ERROR within %g s", roundedUp(std::max(seconds, 1.5)));
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "rivals_test"); }
