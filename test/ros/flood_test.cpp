// N8: a flood of messages. N7: a reader that does not read. Both leave the odometry in real time, and
// bounded.

#include "child_process.hpp"
#include "odometry_client.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

namespace bs_car_odometry::testing {
namespace {

constexpr double kLatest = 0.5;       // s, back in real time
constexpr double kMostGrowth = 20.0;  // MB: four queues of 200 messages of at most 1 kB, the reader's socket
                                      // buffers, and what the allocator keeps of a peak

/// Publishes wheels and steering at a rate, without waiting for anybody.
class Flood {
 public:
  /// Sends what is due since the last call.
  void send(double rate, const ros::SteadyTime& since) {
    const auto due = static_cast<std::int64_t>((ros::SteadyTime::now() - since).toSec() * rate);
    for (; sent_ < due; ++sent_) sendOne();
  }

  ros::Time sendOne() {
    // Two messages may fall on one reading of the clock, but no two stamps may be the same.
    newest_ = std::max(ros::Time::now(), newest_ + ros::Duration(0, 1));
    ++ticks_;
    wheels_.publish(wheelTicks({ticks_, ticks_, ticks_, ticks_}, newest_));
    steering_.publish(steeringAngle(0.0, newest_));
    return newest_;
  }

  bool connected() const { return wheels_.getNumSubscribers() > 0 && steering_.getNumSubscribers() > 0; }
  std::int64_t sent() const { return sent_; }
  void begin() { sent_ = 0; }

 private:
  ros::NodeHandle node_;
  // As long as the odometry's own.
  ros::Publisher wheels_{node_.advertise<WheelTicks>("wheel_ticks", 200)};
  ros::Publisher steering_{node_.advertise<SteeringAngle>("front_steering", 200)};
  ros::Time newest_;
  std::int64_t ticks_{0};
  std::int64_t sent_{0};
};

class FloodTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(waitFor([this] { return flood_.connected() && odom_.getNumPublishers() > 0; }));
    process_ = alive("/odometry");
    ASSERT_NE(process_, 0);
    // The counters of the test before were further on: it takes two messages to take them anew.
    ASSERT_TRUE(waitFor([this] { return echo(0.1); }));
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(echo(5.0));
  }
  void TearDown() override { EXPECT_EQ(alive("/odometry"), process_) << "invariant 5"; }

  /// Sends one message and waits for its odometry.
  bool echo(double seconds) {
    const ros::Time stamp = flood_.sendOne();
    return waitFor([&] { return newest_ >= stamp; }, seconds);
  }

  /// Sends so many messages a second, and notes what is heard meanwhile.
  /// @return the time that it took [s]
  double flood(double rate, double seconds) {
    heard_ = 0;
    oldest_age_ = 0.0;
    flood_.begin();
    const ros::SteadyTime begin = ros::SteadyTime::now();
    while ((ros::SteadyTime::now() - begin).toSec() < seconds) {
      flood_.send(rate, begin);
      ros::spinOnce();
    }
    return (ros::SteadyTime::now() - begin).toSec();
  }

  void onOdometry(const nav_msgs::Odometry& message) {
    const ros::Time now = ros::Time::now();
    // Every one of a flood is too many for the eigenvalues.
    if (heard_ % 10 == 0) {
      EXPECT_EQ(invariants_.violation(message, now), "");
    }
    ++heard_;
    newest_ = message.header.stamp;
    oldest_age_ = std::max(oldest_age_, (now - message.header.stamp).toSec());
  }

  ros::NodeHandle node_;
  Flood flood_;
  ros::Subscriber odom_{node_.subscribe("odom", 200, &FloodTest::onOdometry, this)};
  Invariants invariants_{InputLimits()};
  std::size_t heard_{0};
  ros::Time newest_;
  double oldest_age_{0.0};  // s
  int process_{0};
};

TEST_F(FloodTest, N8_twenty_thousand_messages_a_second) {
  constexpr double kRate = 20000.0;  // Hz, of wheels and of steering each
  constexpr double kSeconds = 10.0;
  const ProcessSize before = sizeOf(process_);
  const double seconds = flood(kRate, kSeconds);
  const double rate = static_cast<double>(flood_.sent()) / seconds;
  const double oldest = oldest_age_;
  const ros::SteadyTime end = ros::SteadyTime::now();
  EXPECT_TRUE(echo(kLatest)) << "back in real time";
  const double back = (ros::SteadyTime::now() - end).toSec();
  const ProcessSize after = sizeOf(process_);
  std::cout << rate << " messages/s sent, " << heard_ << " heard, " << before.resident << " to "
            << after.resident << " MB\n";
  recordFigure("20 kHz: none older than %g s, back in real time within %g s, at most %g MB more",
               roundedUp(oldest), roundedUp(back), roundedUp(after.resident - before.resident));
  EXPECT_LT(oldest, kLatest) << "queues are bounded: what is late is left out";
  EXPECT_GT(heard_, 1000u) << "it works on meanwhile";
  EXPECT_LT(after.resident - before.resident, kMostGrowth);
}

TEST_F(FloodTest, N7_a_reader_that_does_not_read) {
  constexpr double kRate = 1000.0;  // Hz
  constexpr double kSeconds = 5.0;
  ChildProcess reader({BS_CAR_ODOMETRY_COMPANION, "reader", "__name:=reader"});
  ASSERT_TRUE(waitFor([] { return alive("/reader") != 0; })) << reader.output();
  ASSERT_TRUE(echo(5.0));
  reader.suspend();
  const ProcessSize before = sizeOf(process_);
  flood(kRate, kSeconds);
  const ProcessSize after = sizeOf(process_);
  std::cout << heard_ << " of " << flood_.sent() << " heard, " << before.resident << " to " << after.resident
            << " MB\n";
  recordFigure("beside a reader that is stopped: none older than %g s", roundedUp(oldest_age_));
  EXPECT_LT(oldest_age_, kLatest) << "others are not held up";
  EXPECT_GT(heard_, 0.9 * static_cast<double>(flood_.sent()));
  EXPECT_LT(after.resident - before.resident, kMostGrowth);
  EXPECT_TRUE(echo(kLatest));
  reader.resume();
  EXPECT_TRUE(echo(kLatest));
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "flood_test"); }
