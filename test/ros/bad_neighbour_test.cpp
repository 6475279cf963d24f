// N1: a nodelet that cannot start leaves its manager and its neighbours alone, and says why.

#include "odometry_client.hpp"

#include <gtest/gtest.h>

namespace bs_car_odometry::testing {
namespace {

TEST(BadNeighbour, N1_failure_in_onInit) {
  OdometryClient healthy("", "/manager");
  DiagnosticsListener diagnostics;
  ASSERT_TRUE(healthy.connect());
  for (const char* name :
       {"vehicle/wheelbase", "vehicle/track/front", "encoders/metres_per_tick", "noise/wheel"})
    EXPECT_TRUE(
        diagnostics.waitForStatus("bs_car_odometry: Output", diagnostic_msgs::DiagnosticStatus::ERROR, name));
  for (std::int64_t i = 0; i < 20; ++i) ASSERT_TRUE(healthy.step({i, i, i, i}));
  EXPECT_TRUE(
      diagnostics.waitForStatus("bs_car_odometry: Output", diagnostic_msgs::DiagnosticStatus::OK, ""));
  EXPECT_TRUE(healthy.processLives());
  EXPECT_FALSE(ros::service::exists("/broken/odometry/reset", false)) << "it idles";
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "bad_neighbour_test");
}
