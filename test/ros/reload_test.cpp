// N2: the nodelet is loaded into its manager and unloaded again, over and over, in traffic.

#include "odometry_client.hpp"
#include "restless_driver.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>
#include <nodelet/NodeletLoad.h>
#include <nodelet/NodeletUnload.h>

#include <iostream>

namespace bs_car_odometry::testing {
namespace {

constexpr double kRate = 1000.0;  // Hz

class Reload : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(load_.waitForExistence(ros::Duration(20.0)));
    process_ = alive("/manager");
    ASSERT_NE(process_, 0);
  }

  void load() {
    nodelet::NodeletLoad load;
    load.request.name = "/odometry";
    load.request.type = "bs_car_odometry/OdometryNodelet";
    ASSERT_TRUE(load_.call(load) && load.response.success);
  }

  /// As nodelets are unloaded: whatever is under way in their threads.
  void unload() {
    nodelet::NodeletUnload unload;
    unload.request.name = "/odometry";
    ASSERT_TRUE(unload_.call(unload) && unload.response.success);
  }

  /// Loads, hears a few poses, unloads; then nobody publishes any more.
  void cycle() {
    Invariants invariants{InputLimits()};
    std::size_t heard = 0;
    const ros::Subscriber odom =
        node_.subscribe<nav_msgs::Odometry>("odom", 100, [&](const nav_msgs::Odometry::ConstPtr& message) {
          EXPECT_EQ(invariants.violation(*message, ros::Time::now()), "");
          ++heard;
        });
    load();
    ASSERT_TRUE(waitFor([&] { return heard > 3; })) << "it runs";
    unload();
    ASSERT_TRUE(waitFor([&] { return odom.getNumPublishers() == 0; })) << "it is gone";
    ASSERT_EQ(alive("/manager"), process_) << "invariant 5";
  }

  ros::NodeHandle node_;
  ros::ServiceClient load_{node_.serviceClient<nodelet::NodeletLoad>("/manager/load_nodelet")};
  ros::ServiceClient unload_{node_.serviceClient<nodelet::NodeletUnload>("/manager/unload_nodelet")};
  int process_{0};
};

TEST_F(Reload, N2_unload_and_reload_in_traffic) {
  const int cycles = ros::param::param<int>("~cycles", 100);
  const int warm = std::max(cycles / 5, 10);
  const RestlessDriver traffic(kRate, 10, 0.1);
  for (int i = 0; i < warm; ++i) ASSERT_NO_FATAL_FAILURE(cycle()) << i;
  const ProcessSize before = sizeOf(process_);
  for (int i = warm; i < cycles; ++i) ASSERT_NO_FATAL_FAILURE(cycle()) << i;
  const ProcessSize after = sizeOf(process_);
  std::cout << cycles << " cycles: " << before.resident << " to " << after.resident << " MB, "
            << before.threads << " to " << after.threads << " threads, " << before.files << " to "
            << after.files << " files\n";
  // An odometry that stayed would keep 0.1 MB for wheels that wait alone, and most of them 8 MB.
  EXPECT_LT(after.resident - before.resident, 2.0);
  EXPECT_EQ(after.threads, before.threads);
  recordFigure("%d times at 1 kHz: at most %g MB more, %d threads more", cycles,
               roundedUp(after.resident - before.resident), after.threads - before.threads);
  // Connections that are being closed count, too: no more than topics and services.
  EXPECT_LE(after.files, before.files + 8);
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "reload_test"); }
