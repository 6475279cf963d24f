// Live and from the bag: the node that hears a bag played gives the gains of calibrate_bag.

#include "calibration_client.hpp"
#include "odometry_client.hpp"
#include "tools/temporary_folder.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"

#include <gtest/gtest.h>

namespace bs_car_odometry::testing {
namespace {

constexpr const char* kDuration = "40";  // s
constexpr const char* kPlayed = "4";     // times as fast
constexpr std::uint64_t kPoses = 400;    // 10 Hz; where the filter begins is no update

void run(const std::vector<std::string>& command) {
  ChildProcess program(command);
  ASSERT_EQ(program.waitForExit(60.0), 0) << program.output();
}

TEST(LiveEqualsBag, theNodeGivesTheGainsOfCalibrateBag) {
  const tools::testing::TemporaryFolder folder;
  const std::string config = ros::param::param<std::string>("~config", "");
  const std::string bag = folder.file("drive.bag");
  run({BS_CAR_ODOMETRY_SIMULATE, "--scenario", "slalom_eight", "--duration", kDuration, "--config", config,
       "--output", bag});
  run({BS_CAR_ODOMETRY_CALIBRATE, bag, "--config", config, "--output", folder.file("bag.yaml"), "--no-refine",
       "--set", "calibration/method=joint", "--set", "steering_wait=2.0"});

  CalibrationClient client("live");
  client.set("output", folder.file("live.yaml"));
  ASSERT_TRUE(client.start());
  // The player waits until every topic is heard; what it would print, nobody reads.
  const boost::function<void(const nav_msgs::Odometry::ConstPtr&)> nothing = [](const auto&) {};
  const ros::Subscriber truth = ros::NodeHandle().subscribe("/live/ground_truth", 10, nothing);
  ChildProcess player({"rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate", kPlayed, bag,
                       "wheel_ticks:=/live/wheel_ticks", "front_steering:=/live/front_steering",
                       "laser_pose:=/live/laser_pose", "ground_truth:=/live/ground_truth"});
  ASSERT_TRUE(waitFor([&] { return client.state() && client.state()->accepted >= kPoses; }, 60.0))
      << (client.state() ? client.state()->accepted : 0) << " laser poses accepted, "
      << (client.state() ? client.state()->dropped : 0) << " dropped";
  ASSERT_TRUE(client.call("save").success);

  const Parameters parameters =
      loadParameters(parameterServerTree(ros::NodeHandle(client.node()))).parameters;
  const auto live = calibration::readCalibrationFile(folder.file("live.yaml"), parameters);
  const auto recorded = calibration::readCalibrationFile(folder.file("bag.yaml"), parameters);
  EXPECT_EQ(live.listed, recorded.listed);
  EXPECT_EQ(live.data.laser_poses, recorded.data.laser_poses);
  for (std::size_t i = 0; i < calibration::kCount; ++i) {
    if (!live.listed[i]) continue;
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(live.values[k], recorded.values[k], 1e-9) << calibration::parameterName(i);
    EXPECT_NEAR(client.state()->value[i], recorded.values[k], 1e-9) << calibration::parameterName(i);
  }
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "calibration_live_equals_bag_test");
}
