// N3, N4, N5: the nodes and their master, which the test starts and ends itself.

#include "child_process.hpp"
#include "odometry_client.hpp"
#include "support/figure.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <std_srvs/Trigger.h>
#include <sys/socket.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <memory>

namespace bs_car_odometry::testing {
namespace {

using ::testing::HasSubstr;

constexpr double kLongestExit = 2.0;  // s

/// A port that nobody uses.
int freePort() {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  ::bind(descriptor, reinterpret_cast<sockaddr*>(&address), length);
  ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length);
  ::close(descriptor);
  return ntohs(address.sin_port);
}

const int kPort = freePort();

std::unique_ptr<ChildProcess> startMaster() {
  auto master = std::make_unique<ChildProcess>(
      std::vector<std::string>{"rosmaster", "--core", "-p", std::to_string(kPort)});
  const bool runs = waitFor([] { return ros::master::check(); });
  EXPECT_TRUE(runs) << master->output();
  return master;
}

void setParameters(const std::string& node) {
  for (const char* name : {"vehicle/wheelbase", "vehicle/track/front", "vehicle/track/rear"})
    ros::param::set(node + "/" + name, 1.2);
  for (const char* wheel : {"front_left", "front_right", "rear_left", "rear_right"})
    ros::param::set(node + "/encoders/metres_per_tick/" + wheel, 1e-4);
  ros::param::set(node + "/initial_pose/x", 3.0);
}

std::unique_ptr<ChildProcess> startOdometry() {
  return std::make_unique<ChildProcess>(std::vector<std::string>{BS_CAR_ODOMETRY_NODE, "__name:=odometry"});
}

/// Its services are the last thing that it offers but for its inputs.
std::unique_ptr<ChildProcess> startCalibration() {
  setParameters("/calibration");
  auto calibration = std::make_unique<ChildProcess>(
      std::vector<std::string>{BS_CAR_ODOMETRY_CALIBRATION_NODE, "__name:=calibration"});
  EXPECT_TRUE(waitFor([] { return ros::service::exists("/calibration/save", false); }))
      << calibration->output();
  return calibration;
}

/// Ends it as Ctrl-C does.
void expectQuickExit(ChildProcess& process) {
  const ros::SteadyTime begin = ros::SteadyTime::now();
  process.interrupt();
  EXPECT_EQ(process.waitForExit(10.0), 0) << process.output();
  const double seconds = (ros::SteadyTime::now() - begin).toSec();
  recordFigure("ends within %g s", roundedUp(seconds));
  EXPECT_LT(seconds, kLongestExit);
}

class Master : public ::testing::Test {
 protected:
  void SetUp() override {
    master_ = startMaster();
    setParameters("/odometry");
  }

  std::unique_ptr<ChildProcess> master_;
};

TEST_F(Master, N3_ends_within_two_seconds) {
  const auto odometry = startOdometry();
  OdometryClient client("", "/odometry");
  ASSERT_TRUE(client.connect()) << odometry->output();
  ASSERT_TRUE(client.step({0, 0, 0, 0}));
  expectQuickExit(*odometry);
}

TEST_F(Master, N3_the_calibration_ends_within_two_seconds) { expectQuickExit(*startCalibration()); }

TEST_F(Master, N3_the_calibration_ends_within_two_seconds_when_the_master_is_gone) {
  const auto calibration = startCalibration();
  master_->kill();
  expectQuickExit(*calibration);
}

TEST_F(Master, N3_ends_within_two_seconds_when_the_master_is_gone) {
  const auto odometry = startOdometry();
  OdometryClient client("", "/odometry");
  ASSERT_TRUE(client.connect()) << odometry->output();
  ASSERT_TRUE(client.step({0, 0, 0, 0}));
  master_->kill();
  ASSERT_TRUE(client.step({100, 100, 100, 100})) << "data flow without it";
  expectQuickExit(*odometry);
}

TEST_F(Master, N3_ends_within_two_seconds_while_it_waits_for_a_master) {
  master_->kill();
  const auto odometry = startOdometry();
  ASSERT_TRUE(odometry->waitForOutput("Failed to contact master"));
  const ros::SteadyTime begin = ros::SteadyTime::now();
  odometry->interrupt();
  // It never began: that it says so is good, too.
  EXPECT_TRUE(odometry->waitForExit(10.0).has_value()) << odometry->output();
  const double seconds = (ros::SteadyTime::now() - begin).toSec();
  EXPECT_LT(seconds, kLongestExit);
  recordFigure("ends within %g s", roundedUp(seconds));
}

TEST_F(Master, N4_killed_and_started_again_it_begins_at_the_initial_pose) {
  OdometryClient client("", "/odometry");
  {
    const auto odometry = startOdometry();
    ASSERT_TRUE(client.connect()) << odometry->output();
    ASSERT_TRUE(client.step({0, 0, 0, 0}));
    const auto driven = client.step({500, 500, 500, 500});
    ASSERT_TRUE(driven);
    EXPECT_NEAR(driven->pose.pose.position.x, 3.05, 1e-9);
    odometry->kill();
  }
  const auto respawned = startOdometry();
  EXPECT_TRUE(respawned->waitForOutput("a new run begins at the initial pose (3.000 m, 0.000 m, 0.000 rad)"))
      << "the event: " << respawned->output();
  client.announceNewRun();
  const auto first = client.step({600, 600, 600, 600});
  ASSERT_TRUE(first) << respawned->output();
  EXPECT_EQ(first->pose.pose.position.x, 3.0);
  EXPECT_EQ(client.status().wheel_messages, 1u) << "counts begin anew";
  EXPECT_EQ(client.status().distance, 0.0);
  respawned->kill();
}

TEST_F(Master, N5_data_keep_flowing_when_the_master_restarts) {
  const auto odometry = startOdometry();
  OdometryClient client("", "/odometry");
  DiagnosticsListener diagnostics;
  ASSERT_TRUE(client.connect()) << odometry->output();
  ASSERT_TRUE(client.step({0, 0, 0, 0}));
  // The connection of /diagnostics must be there before the master goes.
  ASSERT_TRUE(waitFor([&] { return !diagnostics.timesOf("bs_car_odometry: Output").empty(); }));

  std::int64_t ticks = 0;
  const auto drivesUntilItSays = [&](const std::string& text) {
    std::optional<nav_msgs::Odometry> last;
    EXPECT_TRUE(waitFor([&] {
      ticks += 10;
      last = client.step({ticks, ticks, ticks, ticks});
      return !last ||
             diagnostics.has("bs_car_odometry: Output", diagnostic_msgs::DiagnosticStatus::WARN, text);
    })) << odometry->output();
    ASSERT_TRUE(last) << "data flow";
    EXPECT_NEAR(last->pose.pose.position.x, 3.0 + 1e-4 * static_cast<double>(ticks), 1e-9);
    EXPECT_TRUE(odometry->waitForOutput(text));
  };
  master_->kill();
  drivesUntilItSays("the master does not answer");
  master_ = startMaster();
  drivesUntilItSays("does not know this node");
  expectQuickExit(*odometry);
}

TEST_F(Master, N5_the_calibration_says_that_the_master_restarts) {
  const auto calibration = startCalibration();
  DiagnosticsListener diagnostics;
  const std::string name = "bs_car_odometry: Calibration";
  // The connection of /diagnostics must be there before the master goes.
  ASSERT_TRUE(waitFor([&] { return !diagnostics.timesOf(name).empty(); })) << calibration->output();
  const auto expectThatItSays = [&](const std::string& text) {
    // An error, as nobody drives.
    EXPECT_TRUE(diagnostics.waitForStatus(name, diagnostic_msgs::DiagnosticStatus::ERROR, text));
    EXPECT_TRUE(calibration->waitForOutput(text)) << calibration->output();
  };
  master_->kill();
  expectThatItSays("the master does not answer");
  master_ = startMaster();
  expectThatItSays("does not know this node");
  expectQuickExit(*calibration);
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  const std::string uri = "http://127.0.0.1:" + std::to_string(bs_car_odometry::testing::kPort);
  ::setenv("ROS_MASTER_URI", uri.c_str(), 1);
  ::setenv("ROSCONSOLE_STDOUT_LINE_BUFFERED", "1", 1);  // what the children say comes at once
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "master_test", ros::init_options::NoRosout);
  // Before the first handle, which waits for a master.
  const auto master = bs_car_odometry::testing::startMaster();
  const ros::NodeHandle keeps_ros_alive;
  master->kill();
  return RUN_ALL_TESTS();
}
