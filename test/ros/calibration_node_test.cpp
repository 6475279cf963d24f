// A running calibration: what it publishes, what it saves, and that nothing it is sent can disturb it
// (docs/reliability.md, rows C1, C2, C4, C5, C9, C13).

#include "calibration_client.hpp"
#include "odometry_client.hpp"
#include "tools/temporary_folder.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"
#include "bs_car_odometry/simulation/random.hpp"

#include <gmock/gmock.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

namespace bs_car_odometry::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using tools::testing::TemporaryFolder;

constexpr std::size_t kRearRight = systematic::kRearRight;
constexpr std::size_t kRearTrack = systematic::kRearTrack;

Parameters parametersOf(const std::string& node) {
  return loadParameters(parameterServerTree(ros::NodeHandle(node))).parameters;
}

/// Far enough in the past that no stamp of a drive lies in the future.
SimulatedDrive driveOf(const CalibrationClient& client, const std::string& scenario, double duration = 0.0,
                       std::uint64_t seed = 1) {
  SimulatedDriveSettings settings;
  settings.scenario = scenario;
  settings.duration = duration;
  settings.seed = seed;
  settings.truth = false;
  return SimulatedDrive(parametersOf(client.node()), settings,
                        toTime(ros::Time::now()).value() - durationFromSeconds(1000.0));
}

/// The largest of any parameter's values, of which the file must list those that are observed.
double difference(const calibration::CalibrationResult& saved, const CalibrationState& said) {
  double largest = 0.0;
  for (std::size_t i = 0; i < calibration::kCount; ++i) {
    EXPECT_EQ(saved.listed[i], said.observed[i] != 0) << calibration::parameterName(i);
    if (!saved.listed[i]) continue;
    largest = std::max(largest, std::abs(saved.values[static_cast<Eigen::Index>(i)] - said.value[i]));
  }
  return largest;
}

TEST(CalibrationNode, findsTheGainsAndSavesThem) {
  const TemporaryFolder folder;
  CalibrationClient client("good");
  client.set("output", folder.file("gains.yaml"));
  ASSERT_TRUE(client.start());
  EXPECT_THAT(client.call("save").message, HasSubstr("nothing is known yet"));
  SimulatedDrive drive = driveOf(client, "slalom_eight", 30.0);
  ASSERT_TRUE(client.drive(drive, 30.0));

  const CalibrationState& state = *client.state();
  EXPECT_EQ(state.state, CalibrationState::CONVERGED);
  EXPECT_EQ(state.missing, "");
  EXPECT_EQ(state.header.frame_id, "map");
  EXPECT_EQ(state.vehicle, "cycab");
  EXPECT_NEAR(state.value[kRearRight], 1.02, 4.0 * state.deviation[kRearRight]);
  EXPECT_NEAR(state.value[kRearTrack], 1.03, 4.0 * state.deviation[kRearTrack]);
  EXPECT_EQ(state.progress[kRearTrack], 1.0);

  // One message a wheel message from the second laser pose on, 50 Hz; the last ones may be on their way.
  EXPECT_TRUE(waitFor([&] { return client.odometry().size() > 1450; })) << client.odometry().size();
  EXPECT_LE(client.odometry().size(), 1500u);
  EXPECT_EQ(client.odometry().back().header.frame_id, "map");
  EXPECT_EQ(client.odometry().back().child_frame_id, "base_link");

  // The last laser poses may be on their way, too: what is saved is what is said once they have come.
  const auto saves = [&] {
    const std_srvs::Trigger::Response saved = client.call("save");
    EXPECT_TRUE(saved.success) << saved.message;
    return calibration::readCalibrationFile(folder.file("gains.yaml"), parametersOf(client.node()));
  };
  EXPECT_TRUE(waitFor([&] { return difference(saves(), *client.state()) < 1e-9; }))
      << difference(saves(), *client.state());
  client.process().interrupt();
  EXPECT_EQ(client.process().waitForExit(), 0);
  EXPECT_EQ(folder.files(), 1u) << "an orderly end leaves the result alone";
}

TEST(CalibrationNode, startBeginsAnewAndResetToo) {
  CalibrationClient client("anew");
  ASSERT_TRUE(client.start());
  EXPECT_THAT(client.call("save").message, HasSubstr("'output'"));
  SimulatedDrive drive = driveOf(client, "slalom_eight", 60.0);
  for (const char* service : {"start", "reset"}) {
    ASSERT_TRUE(client.drive(drive, 15.0));
    EXPECT_GT(client.state()->accepted, 100u);
    EXPECT_TRUE(client.call(service).success);
    ASSERT_TRUE(waitFor([&] { return client.state()->state == CalibrationState::START; })) << service;
    EXPECT_EQ(client.state()->accepted, 0u);
    EXPECT_EQ(client.state()->value[kRearRight], 1.0);
    client.announceNewRun();
  }
  ASSERT_TRUE(client.drive(drive, 15.0)) << "it begins by itself";
}

TEST(CalibrationNode, C5_doesNotSaveWhatItHasNotSeen) {
  const TemporaryFolder folder;
  CalibrationClient client("straight");
  client.set("output", folder.file("gains.yaml"));
  ASSERT_TRUE(client.start());
  SimulatedDrive drive = driveOf(client, "straight");
  ASSERT_TRUE(client.drive(drive, 21.0));
  EXPECT_EQ(client.state()->state, CalibrationState::RUNNING);
  EXPECT_THAT(client.state()->missing, HasSubstr("front/k_b, rear/k_b: turn "));
  const std_srvs::Trigger::Response refused = client.call("save");
  EXPECT_FALSE(refused.success);
  EXPECT_THAT(refused.message, HasSubstr("not observed yet: front/k_b, rear/k_b: turn "));
  EXPECT_FALSE(std::filesystem::exists(folder.file("gains.yaml")));
}

TEST(CalibrationNode, C5_savesTheRestWhenThatIsAllowed) {
  const TemporaryFolder folder;
  CalibrationClient client("partial");
  client.set("output", folder.file("gains.yaml"));
  client.set("calibration/allow_partial", true);
  ASSERT_TRUE(client.start());
  SimulatedDrive drive = driveOf(client, "straight");
  ASSERT_TRUE(client.drive(drive, 21.0));
  const std_srvs::Trigger::Response saved = client.call("save");
  EXPECT_TRUE(saved.success) << saved.message;
  EXPECT_THAT(saved.message, HasSubstr("left out: front/k_b, rear/k_b"));
  const calibration::CalibrationResult result =
      calibration::readCalibrationFile(folder.file("gains.yaml"), parametersOf(client.node()));
  EXPECT_TRUE(result.listed[kRearRight]);
  EXPECT_FALSE(result.listed[kRearTrack]);
  EXPECT_TRUE(result.not_observed[kRearTrack]);
}

TEST(CalibrationNode, saysAtOnceThatItCannotSave) {
  CalibrationClient client("nowhere");
  client.set("output", "/nowhere/gains.yaml");
  DiagnosticsListener diagnostics;
  ASSERT_TRUE(client.start());
  EXPECT_TRUE(client.process().waitForOutput("/nowhere/gains.yaml"));
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Calibration",
                                        diagnostic_msgs::DiagnosticStatus::ERROR, "/nowhere/gains.yaml"))
      << "beside the wheels that are missing";
}

TEST(CalibrationNode, P1_doesNotStartWithBadParameters) {
  CalibrationClient client("bad");
  client.set("vehicle/wheelbase", -1.0);
  ChildProcess node({BS_CAR_ODOMETRY_CALIBRATION_NODE, "__ns:=bad", "__name:=calibration"});
  EXPECT_EQ(node.waitForExit(), 1);
  EXPECT_THAT(node.output(), HasSubstr("vehicle/wheelbase: "));
}

// --- C1, C2: hostile poses -------------------------------------------------------------------------------

LaserMessage goodPose(const ros::Time& stamp) {
  LaserMessage message;
  message.header.stamp = stamp;
  message.header.frame_id = "map";
  message.pose.pose.orientation.w = 1.0;
  message.pose.covariance[0] = message.pose.covariance[7] = 4e-4;
  message.pose.covariance[35] = 2.5e-5;
  return message;
}

std::vector<double*> numbersOf(LaserMessage& message) {
  auto& position = message.pose.pose.position;
  auto& orientation = message.pose.pose.orientation;
  std::vector<double*> numbers{&position.x,    &position.y,    &position.z,   &orientation.x,
                               &orientation.y, &orientation.z, &orientation.w};
  for (double& entry : message.pose.covariance) numbers.push_back(&entry);
  return numbers;
}

/// Every number of a pose in turn with every value that is bad or extreme, then all bits at random; always
/// the same for the same pose.
std::vector<LaserMessage> hostilePoses(const LaserMessage& good) {
  constexpr std::uint64_t kSeed = 23;
  constexpr int kRandom = 500;
  const double infinity = std::numeric_limits<double>::infinity();
  const double largest = std::numeric_limits<double>::max();
  std::vector<LaserMessage> messages;
  LaserMessage sample = good;
  for (std::size_t i = 0; i < numbersOf(sample).size(); ++i)
    for (const double value : {std::nan(""), infinity, -infinity, largest, -largest, 5e-324, -1.0, 1e150}) {
      messages.push_back(good);
      *numbersOf(messages.back())[i] = value;
    }
  simulation::Random random(kSeed, 0);
  for (int i = 0; i < kRandom; ++i) {
    messages.push_back(good);
    for (double* number : numbersOf(messages.back())) {
      const std::uint64_t bits = random.bits();
      if (random.uniform() < 0.3) std::memcpy(number, &bits, sizeof bits);
    }
    if (i % 3 == 0) {
      messages.back().header.stamp.sec = static_cast<std::uint32_t>(random.bits());
      messages.back().header.stamp.nsec = static_cast<std::uint32_t>(random.bits());
    }
  }
  return messages;
}

/// Where the car is now, at a stamp a little later each time it is asked for.
LaserMessage presentPose(const CalibrationClient& client, int later) {
  LaserMessage message = goodPose(client.newestWheels() + ros::Duration(0, later));
  message.pose.pose = client.odometry().back().pose.pose;
  return message;
}

TEST(CalibrationNode, C1_nothingHostileGetsThrough) {
  constexpr std::size_t kParts = 10;  // a second of the drive after each
  CalibrationClient client("hostile");
  ASSERT_TRUE(client.start());
  SimulatedDrive drive = driveOf(client, "slalom_eight", 40.0);
  ASSERT_TRUE(client.drive(drive, 10.0));
  const CalibrationState before = *client.state();
  const std::size_t count = hostilePoses(presentPose(client, 0)).size();
  for (std::size_t i = 0; i < count; ++i) {
    client.send(hostilePoses(presentPose(client, static_cast<int>(i) + 1))[i]);
    if (i % (count / kParts) != 0) continue;
    ASSERT_TRUE(client.drive(drive, 1.0)) << "after " << i << " hostile poses";
  }
  ASSERT_TRUE(client.drive(drive, 15.0));
  const CalibrationState& state = *client.state();
  // Most numbers of a covariance are of z, roll and pitch, which nobody reads: those poses are good ones.
  EXPECT_GT(state.dropped, before.dropped + count / 4);
  EXPECT_EQ(state.state, CalibrationState::CONVERGED);
  // Good ones too many, and outliers, which soft weights bear.
  EXPECT_NEAR(state.value[kRearRight], 1.02, 6.0 * state.deviation[kRearRight]);
  EXPECT_NEAR(state.value[kRearTrack], 1.03, 6.0 * state.deviation[kRearTrack]);
}

TEST(CalibrationNode, C2_saysThatPosesWithoutCovarianceHaveLaserSigma) {
  CalibrationClient client("sigma");
  DiagnosticsListener diagnostics;
  ASSERT_TRUE(client.start());
  LaserMessage message = goodPose(ros::Time::now());
  message.pose.covariance.fill(0.0);
  client.send(message);
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Laser", diagnostic_msgs::DiagnosticStatus::WARN,
                                        "'laser_sigma' is used instead"));
}

// --- C4: the localiser jumps -----------------------------------------------------------------------------

TEST(CalibrationNode, C4_aJumpOfTheLocaliserIsAnEvent) {
  CalibrationClient client("jump");
  DiagnosticsListener diagnostics;
  ASSERT_TRUE(client.start());
  SimulatedDrive drive = driveOf(client, "slalom_eight", 30.0);
  ASSERT_TRUE(client.drive(drive, 15.0));
  EXPECT_THAT(client.process().output(), Not(HasSubstr("jumped")));
  client.moveMap({1.0, 0.0, 20.0 * M_PI / 180.0});
  ASSERT_TRUE(client.drive(drive, 5.0));
  EXPECT_EQ(client.state()->relocalisations, 1u);
  EXPECT_TRUE(client.process().waitForOutput(" 20 deg at stamp "));
  EXPECT_THAT(client.process().output(), HasSubstr("the pose is taken anew, the gains are kept"));
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Laser", diagnostic_msgs::DiagnosticStatus::WARN,
                                        "the localiser jumped by "));
}

// --- C9: where the laser sits ----------------------------------------------------------------------------

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = ros::Time::now();
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = x;
  message.transform.rotation.w = 1.0;
  return message;
}

TEST(CalibrationNode, C9_waitsForTheLaserInTfThatComesInPieces) {
  CalibrationClient client("pieces");
  DiagnosticsListener diagnostics;
  ros::NodeHandle handle;
  ros::Publisher tf = handle.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
  SimulatedDrive drive = driveOf(client, "slalom_eight", 30.0);
  client.set("laser/frame", "c9_laser");
  ASSERT_TRUE(client.start());
  client.send(goodPose(ros::Time::now() - ros::Duration(2000.0)));
  EXPECT_TRUE(client.process().waitForOutput("no transform from 'base_link' to 'c9_laser'"));
  EXPECT_THAT(client.process().output(), HasSubstr("since stamp "));
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Laser", diagnostic_msgs::DiagnosticStatus::ERROR,
                                        "no transform from 'base_link' to 'c9_laser'"));
  tf2_msgs::TFMessage pieces;
  pieces.transforms = {transform("c9_mast", "c9_laser", 0.5)};
  tf.publish(pieces);
  // Topics keep no order: this pose may come after both links. Older than the drive, it is then no harm.
  client.send(goodPose(ros::Time::now() - ros::Duration(2000.0)));
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Laser", diagnostic_msgs::DiagnosticStatus::ERROR,
                                        "no transform from 'base_link' to 'c9_laser'"));
  EXPECT_FALSE(client.state()) << "no pose is taken with a mount that is made up";
  pieces.transforms.push_back(transform("base_link", "c9_mast", -0.5));
  tf.publish(pieces);
  // Both links together put the laser at base_link, as in the simulation.
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Laser", diagnostic_msgs::DiagnosticStatus::WARN,
                                        "no laser pose"));
  ASSERT_TRUE(client.drive(drive, 20.0));
  EXPECT_NEAR(client.state()->value[kRearRight], 1.02, 4.0 * client.state()->deviation[kRearRight]);
}

// --- C13: killed in the middle ---------------------------------------------------------------------------

TEST(CalibrationNode, C13_goesOnAfterKill9) {
  const TemporaryFolder folder;
  const std::string checkpoint = folder.file("gains.yaml.checkpoint");
  CalibrationClient client("killed");
  client.set("output", folder.file("gains.yaml"));
  ASSERT_TRUE(client.start());
  SimulatedDrive drive = driveOf(client, "slalom_eight", 60.0);
  ASSERT_TRUE(client.drive(drive, 20.0));
  ASSERT_TRUE(waitFor([&] { return std::filesystem::exists(checkpoint); })) << "one in ten seconds";
  const CalibrationState before = *client.state();
  client.process().kill();
  client.announceNewRun();

  ASSERT_TRUE(client.start());
  EXPECT_TRUE(client.process().waitForOutput("going on with the calibration"));
  ASSERT_TRUE(client.drive(drive, 2.0));
  const CalibrationState& after = *client.state();
  EXPECT_GT(after.accepted, before.accepted);
  EXPECT_GT(after.distance, before.distance);
  for (const std::size_t gain : {kRearRight, kRearTrack})
    EXPECT_NEAR(after.value[gain], before.value[gain], before.deviation[gain]) << gain;
  EXPECT_LT(after.deviation[kRearTrack], 1.05 * before.deviation[kRearTrack]) << "what was learnt is kept";

  client.call("start");
  EXPECT_FALSE(std::filesystem::exists(checkpoint)) << "whoever begins anew does not go on";
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "calibration_node_test");
}
