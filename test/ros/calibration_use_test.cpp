// C12 in a running odometry: the file that it names, the file that it requires, and messages on
// `calibration`.

#include "child_process.hpp"
#include "odometry_client.hpp"
#include "tools/temporary_folder.hpp"

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/calibration/result_file.hpp"

#include <gmock/gmock.h>

#include <memory>

namespace bs_car_odometry::testing {
namespace {

using ::testing::HasSubstr;
using Level = diagnostic_msgs::DiagnosticStatus;
using tools::testing::TemporaryFolder;

constexpr const char* kTask = "bs_car_odometry: Calibration";

Parameters car() {
  Parameters car;
  car.vehicle.name = "cart";
  car.vehicle.wheelbase = 1.2;
  car.vehicle.track = {1.2, 1.2};
  car.vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  return car;
}

void setCar(const std::string& node) {
  ros::param::set(node + "/vehicle/name", "cart");
  ros::param::set(node + "/vehicle/wheelbase", 1.2);
  ros::param::set(node + "/vehicle/track", 1.2);
  for (const Wheel wheel : kAllWheels)
    ros::param::set(node + "/encoders/metres_per_tick/" + name(wheel), 1e-4);
}

calibration::CalibrationResult found() {
  calibration::CalibrationResult result;
  result.listed[systematic::kRearRight] = true;
  result.values[systematic::kRearRight] = 1.0125;
  result.covariance(systematic::kRearRight, systematic::kRearRight) = 1e-6;
  return result;
}

std::unique_ptr<ChildProcess> start(const std::string& node) {
  return std::make_unique<ChildProcess>(
      std::vector<std::string>{BS_CAR_ODOMETRY_NODE, "__name:=" + node.substr(1), "__ns:=" + node + "_ns"});
}

/// A node of its own namespace, with the car's parameters.
class CalibrationUse : public ::testing::Test {
 protected:
  std::string prepare(const std::string& name) {
    const std::string node = "/" + name + "_ns/" + name;
    setCar(node);
    return node;
  }
  std::unique_ptr<ChildProcess> run(const std::string& name) { return start("/" + name); }

  DiagnosticsListener diagnostics_;
  TemporaryFolder folder_;
};

TEST_F(CalibrationUse, C12_launch_files_pass_the_file_on) {
  EXPECT_TRUE(diagnostics_.waitForStatus(kTask, Level::ERROR, "/none/launched.yaml cannot be read"));
}

TEST_F(CalibrationUse, C12_a_nodelet_that_requires_its_file_idles) {
  EXPECT_TRUE(diagnostics_.waitForStatus("bs_car_odometry: Output", Level::ERROR, "/none/required.yaml"));
}

TEST_F(CalibrationUse, C12_a_node_that_requires_its_file_ends) {
  ros::param::set(prepare("no_file") + "/require_calibration", true);
  const auto no_file = run("no_file");
  EXPECT_EQ(no_file->waitForExit(), 1);
  EXPECT_THAT(no_file->output(), HasSubstr("calibration_file names no file; name one"));

  const std::string text = calibration::toText(found(), car());
  const std::string node = prepare("cut_file");
  ros::param::set(node + "/require_calibration", true);
  ros::param::set(node + "/calibration_file", folder_.write("cut.yaml", text.substr(0, 300)));
  const auto cut_file = run("cut_file");
  EXPECT_EQ(cut_file->waitForExit(), 1);
  EXPECT_THAT(cut_file->output(), HasSubstr("cut.yaml is not used: "));
}

TEST_F(CalibrationUse, C12_without_that_it_runs_on_the_gains_of_the_vehicle) {
  Parameters other = car();
  other.vehicle.name = "another";
  const std::string path = folder_.write("other.yaml", calibration::toText(found(), other));
  ros::param::set(prepare("other_car") + "/calibration_file", path);
  const auto process = run("other_car");
  EXPECT_TRUE(process->waitForOutput("the gains are those of the vehicle file: " + path));
  EXPECT_TRUE(diagnostics_.waitForStatus(kTask, Level::ERROR, "another car: its name is 'another'"));
}

TEST_F(CalibrationUse, a_whole_file_is_used) {
  const std::string path = folder_.file("car.yaml");
  calibration::writeCalibrationFile(path, found(), car());
  const std::string node = prepare("calibrated");
  ros::param::set(node + "/calibration_file", path);
  ros::param::set(node + "/require_calibration", true);
  const auto process = run("calibrated");
  EXPECT_TRUE(diagnostics_.waitForStatus(kTask, Level::OK, "the gains are those of " + path))
      << process->output();
}

CalibrationState message(const Parameters& car) {
  CalibrationState message;
  message.vehicle = car.vehicle.name;
  message.vehicle_checksum = calibration::vehicleChecksum(car);
  const calibration::ParameterVector values = calibration::valuesOf(car);
  std::copy(values.data(), values.data() + calibration::kCount, message.value.begin());
  message.value[systematic::kRearRight] = 1.0125;
  message.observed[systematic::kRearRight] = 1;
  message.covariance[systematic::kRearRight * (calibration::kCount + 1)] = 1e-6;
  return message;
}

TEST_F(CalibrationUse, nothing_is_subscribed_unless_asked_for) {
  ros::NodeHandle handle("/deaf_ns");
  const ros::Publisher publisher = handle.advertise<CalibrationState>("calibration", 1, true);
  const ros::Publisher pose = handle.advertise<geometry_msgs::PoseWithCovarianceStamped>("set_pose", 1);
  publisher.publish(message(car()));
  prepare("deaf");
  const auto process = run("deaf");
  // Subscribed one after the other: with the wheels, the last, all are there.
  const ros::Publisher wheels = handle.advertise<WheelTicks>("wheel_ticks", 1);
  ASSERT_TRUE(waitFor([&] { return wheels.getNumSubscribers() > 0 && pose.getNumSubscribers() > 0; }));
  EXPECT_EQ(publisher.getNumSubscribers(), 0u);
}

TEST_F(CalibrationUse, messages_are_applied_where_asked_for) {
  ros::NodeHandle handle("/hearing_ns");
  const ros::Publisher publisher = handle.advertise<CalibrationState>("calibration", 1, true);
  ros::param::set(prepare("hearing") + "/accept_calibration", true);
  const auto process = run("hearing");
  ASSERT_TRUE(waitFor([&] { return publisher.getNumSubscribers() > 0; }));
  Parameters other = car();
  other.vehicle.wheelbase = 1.3;
  publisher.publish(message(other));
  EXPECT_TRUE(diagnostics_.waitForStatus(kTask, Level::WARN, "refused: it is another car's"));
  publisher.publish(message(car()));
  EXPECT_TRUE(diagnostics_.waitForStatus(kTask, Level::OK, "those of the calibration that runs"));
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "calibration_use_test");
}
