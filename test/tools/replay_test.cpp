// replay(): what it writes, and what it says of bags that it cannot use.

#include "../../src/tools/replay.hpp"

#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/calibration/result_file.hpp"
#include "temporary_folder.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gmock/gmock.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <sys/resource.h>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::HasSubstr;

Parameters cycab() {
  Parameters parameters;
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  return parameters;
}

/// A straight drive at 1 m/s, 20 Hz; a pose is set after its first half.
void writeDrive(const std::string& path, int messages, bool set_pose = false) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  for (int i = 0; i < messages; ++i) {
    const ros::Time stamp(1000.0 + 0.05 * i);
    SteeringAngle steering;
    steering.header.stamp = stamp;
    bag.write("/front_steering", stamp, steering);
    WheelTicks wheels;
    wheels.header.stamp = stamp;
    wheels.front_left = wheels.front_right = wheels.rear_left = wheels.rear_right = 500 * i;
    bag.write("/wheel_ticks", stamp, wheels);
    if (!set_pose || i != messages / 2) continue;
    geometry_msgs::PoseWithCovarianceStamped pose;
    pose.pose.pose.position.y = 7.0;
    pose.pose.pose.orientation.w = 1.0;
    bag.write("/set_pose", stamp + ros::Duration(0.01), pose);
  }
}

std::string errorOfReplay(const ReplayFiles& files) {
  return errorOf([&] { replay(cycab(), TopicNames(), files); });
}

nav_msgs::Odometry lastOdometry(const std::string& path) {
  const rosbag::Bag bag(path);
  nav_msgs::Odometry last;
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery("odom")))
    last = *message.instantiate<nav_msgs::Odometry>();
  return last;
}

TEST(Replay, writesTheOdometryOfTheDrive) {
  const TemporaryFolder folder;
  writeDrive(folder.file("in.bag"), 21);
  replay(cycab(), TopicNames(), {folder.file("in.bag"), folder.file("out.bag"), folder.file("path.tum")});
  EXPECT_NEAR(lastOdometry(folder.file("out.bag")).pose.pose.position.x, 1.0, 1e-9);
}

const char* const kCycabFile =
    "vehicle: {name: cycab, wheelbase: 1.2, track: 1.2}\n"
    "encoders: {metres_per_tick: {front_left: 1.0e-4, front_right: 1.0e-4, rear_left: 1.0e-4, rear_right: "
    "1.0e-4}}\n";

/// Gains and steering that no short text says.
calibration::CalibrationResult found() {
  calibration::CalibrationResult result;
  for (std::size_t i = 0; i < systematic::kCount; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    result.listed[i] = calibration::isGain(i) || i == systematic::kFrontOffset;
    if (!result.listed[i]) continue;
    result.values[k] = calibration::isGain(i) ? 1.0 + 1.0 / (30.0 + static_cast<double>(i)) : 1.0 / 70.0;
    result.covariance(k, k) = 1e-6;
  }
  return result;
}

/// The same values as settings of a vehicle file.
std::vector<std::string> settingsOf(const calibration::CalibrationResult& result) {
  std::vector<std::string> settings;
  for (std::size_t i = 0; i < systematic::kCount; ++i) {
    if (!result.listed[i]) continue;
    char value[40];
    std::snprintf(value, sizeof value, "=%.17g", result.values[static_cast<Eigen::Index>(i)]);
    const std::string name = calibration::parameterName(i);
    settings.push_back(calibration::isGain(i) ? "gains/" + name + value
                                              : std::string("steering/front/offset") + value);
  }
  return settings;
}

/// A turn, so that every gain has an effect.
TEST(Replay, aCalibrationIsWorthItsGainsInTheVehicleFileBitForBit) {
  const TemporaryFolder folder;
  {
    rosbag::Bag bag(folder.file("in.bag"), rosbag::bagmode::Write);
    for (int i = 0; i < 200; ++i) {
      const ros::Time stamp(1000.0 + 0.05 * i);
      SteeringAngle steering;
      steering.header.stamp = stamp;
      steering.angle = 0.1;
      bag.write("/front_steering", stamp, steering);
      WheelTicks wheels;
      wheels.header.stamp = stamp;
      wheels.front_left = wheels.rear_left = 480 * i;
      wheels.front_right = wheels.rear_right = 520 * i;
      bag.write("/wheel_ticks", stamp, wheels);
    }
  }
  const std::string config = folder.write("cycab.yaml", kCycabFile);
  const std::string file = folder.file("found.yaml");
  const Parameters calibrated = loadCalibratedVehicle({config}, settingsOf(found()));
  calibration::writeCalibrationFile(file, found(), calibrated);
  const auto path = [&](const Parameters& parameters) {
    replay(parameters, TopicNames(), {folder.file("in.bag"), folder.file("out.bag"), ""});
    const rosbag::Bag bag(folder.file("out.bag"));
    std::vector<std::array<double, 4>> poses;
    for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery("odom"))) {
      const geometry_msgs::Pose pose = message.instantiate<nav_msgs::Odometry>()->pose.pose;
      poses.push_back({pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w});
    }
    return poses;
  };
  const auto expected = path(calibrated);
  const auto nominal = path(loadCalibratedVehicle({config}, {}));
  EXPECT_EQ(path(loadCalibratedVehicle({config}, {"calibration_file=" + file})), expected);
  EXPECT_NE(nominal, expected);
}

TEST(Replay, C12_ofACalibrationThatIsNotWholeThereIsNone) {
  const TemporaryFolder folder;
  const std::string config = folder.write("cycab.yaml", kCycabFile);
  const std::string text = calibration::toText(found(), loadCalibratedVehicle({config}, {}));
  const auto error = [&](const std::vector<std::string>& settings) {
    return errorOf([&] { loadCalibratedVehicle({config}, settings); });
  };
  const std::string cut = folder.write("cut.yaml", text.substr(0, 400));
  EXPECT_THAT(error({"calibration_file=" + cut}),
              HasSubstr("cut.yaml is not used: its last line is no checksum"));
  const std::string whole = folder.write("whole.yaml", text);
  EXPECT_EQ(error({"calibration_file=" + whole}), "");
  EXPECT_THAT(error({"calibration_file=" + whole, "vehicle/wheelbase=1.3"}), HasSubstr("another car"));
  EXPECT_THAT(error({"require_calibration=true"}), HasSubstr("names no file"));
}

TEST(Replay, obeysPosesThatWereSet) {
  const TemporaryFolder folder;
  writeDrive(folder.file("in.bag"), 21, true);
  replay(cycab(), TopicNames(), {folder.file("in.bag"), folder.file("out.bag"), ""});
  const nav_msgs::Odometry last = lastOdometry(folder.file("out.bag"));
  EXPECT_NEAR(last.pose.pose.position.x, 0.5, 1e-9);
  EXPECT_EQ(last.pose.pose.position.y, 7.0);
}

std::vector<OdometryStatus> statuses(const std::string& path) {
  const rosbag::Bag bag(path);
  std::vector<OdometryStatus> statuses;
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery("odometry_status")))
    statuses.push_back(*message.instantiate<OdometryStatus>());
  return statuses;
}

TEST(Replay, particlesAreTheSameOnEveryRunAndFillTheQuantiles) {
  const TemporaryFolder folder;
  writeDrive(folder.file("in.bag"), 41, true);
  Parameters parameters = cycab();
  parameters.odometry.uncertainty = Uncertainty::kMonteCarlo;
  parameters.odometry.particles.count = 1000;
  replay(parameters, TopicNames(), {folder.file("in.bag"), folder.file("one.bag"), ""});
  parameters.odometry.particles.threads = 2;
  replay(parameters, TopicNames(), {folder.file("in.bag"), folder.file("two.bag"), ""});
  const nav_msgs::Odometry odometry = lastOdometry(folder.file("one.bag"));
  EXPECT_EQ(odometry, lastOdometry(folder.file("two.bag")));
  const OdometryStatus status = statuses(folder.file("one.bag")).back();
  EXPECT_EQ(status, statuses(folder.file("two.bag")).back());
  ASSERT_EQ(status.quantiles_x.size(), 7u);
  EXPECT_EQ(status.quantile_levels.size(), 7u);
  EXPECT_NEAR(status.quantile_levels[3], 0.5, 1e-12);
  // Along the straight line nearly Gaussian: the median within four of its standard errors, 1.25 /
  // sqrt(1000).
  const double sigma = std::sqrt(odometry.pose.covariance[0]);
  EXPECT_NEAR(status.quantiles_x[3], odometry.pose.pose.position.x, 0.16 * sigma);
  EXPECT_LT(status.quantiles_x[2], status.quantiles_x[3] - 0.8 * sigma);
  EXPECT_GT(status.quantiles_x[4], status.quantiles_x[3] + 0.8 * sigma);
  EXPECT_EQ(status.quantiles_y.size(), 7u);
  EXPECT_EQ(status.quantiles_yaw.size(), 7u);
}

TEST(Replay, otherMethodsHaveNoQuantiles) {
  const TemporaryFolder folder;
  writeDrive(folder.file("in.bag"), 3);
  replay(cycab(), TopicNames(), {folder.file("in.bag"), folder.file("out.bag"), ""});
  EXPECT_TRUE(statuses(folder.file("out.bag")).back().quantile_levels.empty());
}

TEST(Replay, saysWhatIsWrongWithABag) {
  const TemporaryFolder folder;
  const std::string in = folder.file("in.bag");
  const std::string out = folder.file("out.bag");
  EXPECT_THAT(errorOfReplay({folder.file("none.bag"), out, ""}), HasSubstr("cannot be read"));
  { const rosbag::Bag empty(in, rosbag::bagmode::Write); }
  EXPECT_THAT(errorOfReplay({in, out, ""}), HasSubstr("no messages"));
  {
    rosbag::Bag bag(in, rosbag::bagmode::Write);
    bag.write("/wheel_ticks", ros::Time(1000.0), SteeringAngle());
  }
  EXPECT_THAT(errorOfReplay({in, out, ""}), HasSubstr("/wheel_ticks is a bs_car_odometry/SteeringAngle"));
  {
    rosbag::Bag bag(in, rosbag::bagmode::Write);
    bag.write("/wheel_ticks", ros::Time(1000.0), WheelTicks());
  }
  EXPECT_THAT(errorOfReplay({in, out, ""}), HasSubstr("no topic /front_steering"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Replay, refusesToOverwriteItsOwnFiles) {
  const TemporaryFolder folder;
  const std::string in = folder.file("in.bag");
  writeDrive(in, 3);
  const auto size = std::filesystem::file_size(in);
  EXPECT_THAT(errorOfReplay({in, in, ""}), HasSubstr("different files"));
  EXPECT_THAT(errorOfReplay({in, "", folder.file("./in.bag")}), HasSubstr("different files"));
  EXPECT_THAT(errorOfReplay({in, folder.file("out"), folder.file("out")}), HasSubstr("different files"));
  EXPECT_EQ(std::filesystem::file_size(in), size);
}

/// A limit on the size of files stands for the full disk.
TEST(Replay, aFullDiskIsAnErrorAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  writeDrive(folder.file("in.bag"), 20000);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{200000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const int status = runTool("replay_bag", [&] {
    replay(cycab(), TopicNames(), {folder.file("in.bag"), folder.file("out.bag"), ""});
  });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(status, kInputErrorStatus);
  EXPECT_EQ(folder.files(), 1u) << "the input alone";
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
