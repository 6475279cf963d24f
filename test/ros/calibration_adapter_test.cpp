// From messages to the calibration, without a master: which laser poses are taken and how, the laser's mount
// from tf, and a whole drive (docs/reliability.md, rows C1, C2, C9).

#include "bs_car_odometry/ros/calibration_adapter.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/simulated_drive.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <type_traits>

namespace bs_car_odometry {
namespace {

using calibration::CalibrationUpdate;
using calibration::FilterEstimate;
using calibration::LaserPose;
using calibration::LaserVerdict;
using geometry_msgs::PoseWithCovarianceStamped;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Parameters cycab() {
  Parameters parameters;
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  parameters.odometry.axles = AxleSelection::kRear;
  return parameters;
}

PoseWithCovarianceStamped poseMessage(double stamp) {
  PoseWithCovarianceStamped message;
  message.header.stamp = ros::Time(stamp);
  message.header.frame_id = "map";
  message.pose.pose.orientation = toQuaternion(0.5);
  message.pose.covariance[0] = message.pose.covariance[7] = 4e-4;
  message.pose.covariance[35] = 2.5e-5;
  return message;
}

/// What becomes of a message that a reader receives at its stamp.
LaserVerdict verdictOf(const PoseWithCovarianceStamped& message) {
  LaserPoseReader reader(cycab());
  const auto read = reader.read(message, message.header.stamp);
  return std::holds_alternative<LaserPose>(read) ? LaserVerdict::kAccepted : std::get<LaserVerdict>(read);
}

TEST(LaserPoses, C1_posesThatAreNoneAreDropped) {
  EXPECT_EQ(verdictOf(poseMessage(100.0)), LaserVerdict::kAccepted);
  for (const double norm : {0.0, 0.89, 1.11, kNan}) {
    PoseWithCovarianceStamped message = poseMessage(100.0);
    message.pose.pose.orientation.z *= norm;
    message.pose.pose.orientation.w *= norm;
    EXPECT_EQ(verdictOf(message), LaserVerdict::kNotFinite) << "quaternion of norm " << norm;
  }
  PoseWithCovarianceStamped message = poseMessage(100.0);
  message.pose.pose.position.y = std::numeric_limits<double>::infinity();
  EXPECT_EQ(verdictOf(message), LaserVerdict::kNotFinite);
}

TEST(LaserPoses, C1_aQuaternionNearlyOfUnitNormIsNormalised) {
  PoseWithCovarianceStamped message = poseMessage(100.0);
  message.pose.pose.orientation.z *= 1.05;
  message.pose.pose.orientation.w *= 1.05;
  LaserPoseReader reader(cycab());
  EXPECT_NEAR(std::get<LaserPose>(reader.read(message, ros::Time(100.0))).pose.yaw, 0.5, 1e-15);
}

TEST(LaserPoses, C2_whereACovarianceIsMissingLaserSigmaHolds) {
  boost::array<double, 36> message{};
  EXPECT_TRUE(lacksCovariance(message));
  const LaserSigma sigma{0.03, 0.01};
  EXPECT_EQ(laserCovariance(message, sigma).value(),
            Eigen::Matrix3d(Eigen::Vector3d(9e-4, 9e-4, 1e-4).asDiagonal()));
  message[35] = 0.25;  // a yaw alone
  EXPECT_TRUE(lacksCovariance(message));
  EXPECT_EQ(laserCovariance(message, sigma).value(),
            Eigen::Matrix3d(Eigen::Vector3d(9e-4, 9e-4, 0.25).asDiagonal()));
  EXPECT_FALSE(lacksCovariance(poseMessage(100.0).pose.covariance));
}

TEST(LaserPoses, C2_aCovarianceThatIsNoneIsDropped) {
  const std::size_t x = 0;
  const std::size_t xy = 1;
  const std::size_t yaw = 35;
  for (const auto& [entry, value] : {std::pair(x, -1e-4), std::pair(x, 0.0), std::pair(x, kNan),
                                     std::pair(yaw, -1e-9), std::pair(xy, 1e-3), std::pair(x, 1e300)}) {
    PoseWithCovarianceStamped message = poseMessage(100.0);
    message.pose.covariance[entry] = value;
    if (entry == xy) message.pose.covariance[6] = value;
    EXPECT_EQ(verdictOf(message), LaserVerdict::kBadCovariance) << entry << ": " << value;
  }
}

TEST(LaserPoses, stampsFollowTheRulesOfTheOtherInputs) {
  LaserPoseReader reader(cycab());
  const auto verdict = [&reader](const ros::Time& stamp, const ros::Time& receipt) {
    PoseWithCovarianceStamped message = poseMessage(100.0);
    message.header.stamp = stamp;
    const auto read = reader.read(message, receipt);
    return std::holds_alternative<LaserPose>(read) ? LaserVerdict::kAccepted : std::get<LaserVerdict>(read);
  };
  EXPECT_EQ(verdict(ros::Time(), ros::Time(100.0)), LaserVerdict::kStampZero);
  ros::Time invalid(100, 0);
  invalid.nsec = 1000000000;
  EXPECT_EQ(verdict(invalid, ros::Time(200.0)), LaserVerdict::kStampInvalid);
  EXPECT_EQ(verdict(ros::Time(100.11), ros::Time(100.0)), LaserVerdict::kFuture) << "max_future is 0.1 s";
  EXPECT_EQ(verdict(ros::Time(100.09), ros::Time(100.0)), LaserVerdict::kAccepted);
}

TEST(LaserPoses, theTimeOfReceiptStandsInForTheStamp) {
  Parameters parameters = cycab();
  parameters.stamp_source = StampSource::kReceipt;
  LaserPoseReader reader(parameters);
  const auto read = reader.read(poseMessage(0.0), ros::Time(100.0));
  EXPECT_EQ(std::get<LaserPose>(read).stamp, toTime(ros::Time(100.0)));
}

TEST(LaserPoses, posesInAnotherMapAreDropped) {
  LaserPoseReader reader(cycab());
  PoseWithCovarianceStamped message = poseMessage(100.0);
  message.header.frame_id = "/map";
  reader.read(message, ros::Time(100.0));
  EXPECT_EQ(reader.mapFrame(), "map");
  message.header.frame_id = "other_map";
  EXPECT_EQ(std::get<LaserVerdict>(reader.read(message, ros::Time(100.0))), LaserVerdict::kOtherFrame);
  reader.forgetMap();
  reader.read(message, ros::Time(100.0));
  EXPECT_EQ(reader.mapFrame(), "other_map");
}

tf2_msgs::TFMessage transform(const std::string& parent, const std::string& child, double x, double yaw) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.frame_id = parent;
  message.transforms[0].header.stamp = ros::Time(100.0);
  message.transforms[0].child_frame_id = child;
  message.transforms[0].transform.translation.x = x;
  message.transforms[0].transform.translation.z = 1.5;
  message.transforms[0].transform.rotation = toQuaternion(yaw);
  return message;
}

TEST(LaserMount, C9_isPutTogetherFromPiecesOfTf) {
  Parameters parameters = cycab();
  parameters.laser.frame = "laser";
  CalibrationAdapter adapter(parameters);
  EXPECT_EQ(adapter.add(poseMessage(100.0), ros::Time(100.5)), LaserVerdict::kNoMount);
  adapter.add(transform("mast", "laser", 1.0, 0.25));
  EXPECT_FALSE(adapter.mountKnown());
  const std::string waiting = adapter.waitingForMount(ros::Time(102.0));
  EXPECT_THAT(waiting, HasSubstr("'base_link' to 'laser'"));
  EXPECT_THAT(waiting, HasSubstr("stamp 100.000, 1.5 s ago"));
  EXPECT_EQ(adapter.calibrator().counts().dropped + adapter.calibrator().counts().used, 0u)
      << "no pose is taken with a mount that is made up";
  adapter.add(transform("base_link", "mast", 0.5, M_PI / 2.0));
  ASSERT_TRUE(adapter.mountKnown());
  EXPECT_EQ(adapter.waitingForMount(ros::Time(102.0)), "");
  EXPECT_NEAR(adapter.parameters().laser.x, 0.5, 1e-12);
  EXPECT_NEAR(adapter.parameters().laser.y, 1.0, 1e-12);
  EXPECT_NEAR(adapter.parameters().laser.yaw, M_PI / 2.0 + 0.25, 1e-12);
  EXPECT_EQ(adapter.add(poseMessage(103.0), ros::Time(103.0)), LaserVerdict::kAccepted);
  EXPECT_EQ(adapter.laserCounts()[LaserVerdict::kNoMount], 1u);
}

TEST(LaserMount, C9_transformsThatAreNoneAreAsGoodAsAbsent) {
  Parameters parameters = cycab();
  parameters.laser.frame = "laser";
  CalibrationAdapter adapter(parameters);
  adapter.add(transform("base_link", "laser", kNan, 0.0));
  EXPECT_FALSE(adapter.mountKnown());
}

/// A simulated drive, message by message.
void drive(CalibrationAdapter& adapter, const Parameters& parameters, std::uint64_t seed) {
  SimulatedDriveSettings settings;
  settings.seed = seed;
  SimulatedDrive simulated(parameters, settings, Time(durationFromSeconds(1.6e9)));
  while (const std::optional<SimulatedMessage> message = simulated.next()) {
    const ros::Time receipt = toRos(message->receipt);
    while (adapter.next(receipt)) {
    }
    const auto give = [&](const auto& content) {
      using Content = std::decay_t<decltype(content)>;
      if constexpr (std::is_same_v<Content, WheelTicks> || std::is_same_v<Content, PoseWithCovarianceStamped>)
        adapter.add(content, receipt);
      else if constexpr (std::is_same_v<Content, SteeringAngle>)
        adapter.add(Axle::kFront, content, receipt);
    };
    std::visit(give, message->content);
  }
  adapter.finish();
}

TEST(CalibrationAdapter, findsTheGainsOfADrive) {
  CalibrationAdapter adapter(cycab());
  std::size_t heard = 0;
  adapter.setListener([&heard](const CalibrationUpdate&) { ++heard; });
  drive(adapter, cycab(), 1);
  EXPECT_GT(heard, 100u) << "a laser pose every 0.1 s for 15 s";
  EXPECT_EQ(adapter.mapFrame(), "map");
  const FilterEstimate estimate = adapter.calibrator().estimate();
  constexpr std::array<std::size_t, 3> gains{systematic::kRearRight, systematic::kRearLeft,
                                             systematic::kRearTrack};
  constexpr std::array<double, 3> truth{1.02, 0.99, 1.03};
  for (std::size_t i = 0; i < gains.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(gains[i]);
    // Four standard deviations: three values, one drive of a fixed seed.
    EXPECT_NEAR(estimate.values[k], truth[i], 4.0 * std::sqrt(estimate.covariance(k, k)))
        << calibration::parameterName(gains[i]);
    EXPECT_LT(std::sqrt(estimate.covariance(k, k)), 0.01) << "the bound of this drive is below 0.009";
  }
}

TEST(CalibrationAdapter, aSecondDriveGoesOnWithTheGainsOfTheFirst) {
  CalibrationAdapter adapter(cycab());
  drive(adapter, cycab(), 1);
  const FilterEstimate first = adapter.calibrator().estimate();
  adapter.newDrive();
  EXPECT_EQ(adapter.calibrator().estimate().values, first.values);
  drive(adapter, cycab(), 2);
  const FilterEstimate second = adapter.calibrator().estimate();
  const auto k = static_cast<Eigen::Index>(systematic::kRearTrack);
  // Two like drives tell at least 1/sqrt(2) of the deviation, and the prior of 0.05 next to nothing.
  EXPECT_NEAR(std::sqrt(second.covariance(k, k) / first.covariance(k, k)), std::sqrt(0.5), 0.05);
}

}  // namespace
}  // namespace bs_car_odometry
