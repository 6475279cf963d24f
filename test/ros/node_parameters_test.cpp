// P1 to P4: what odometry_node says of the parameters on the server, and whether it starts.

#include "child_process.hpp"
#include "odometry_client.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace bs_car_odometry::testing {
namespace {

using ::testing::HasSubstr;
using Setting = std::function<void(const std::string& node)>;

template <typename Value>
Setting set(const std::string& name, const Value& value) {
  return [name, value](const std::string& node) { ros::param::set(node + "/" + name, value); };
}

const std::vector<std::string> kRequired{"vehicle/wheelbase",
                                         "vehicle/track/front",
                                         "vehicle/track/rear",
                                         "encoders/metres_per_tick/front_left",
                                         "encoders/metres_per_tick/front_right",
                                         "encoders/metres_per_tick/rear_left",
                                         "encoders/metres_per_tick/rear_right"};

void setMinimalVehicle(const std::string& node) {
  for (const std::string& name : kRequired) ros::param::set(node + "/" + name, 1.2);
}

std::vector<std::string> commandOf(const std::string& node) {
  return {BS_CAR_ODOMETRY_NODE, "__name:=" + node.substr(1)};
}

struct BadFile {
  std::string node;
  bool minimal_vehicle;
  std::vector<Setting> settings;
  std::vector<std::string> wrong;  ///< all names that the message must hold

  friend std::ostream& operator<<(std::ostream& stream, const BadFile& file) { return stream << file.node; }
};

const std::vector<BadFile> kBadFiles{
    {"/nothing_set", false, {}, kRequired},
    {"/wrong_types",
     true,
     {set("vehicle/wheelbase", "long"), set("publish_tf", "maybe"), set("encoders/counter_bits", 31.5),
      set("odometry/axles", "middle"), set("joints/front_left", true), set("initial_pose/covariance", 1.0),
      set("noise", "none")},
     {"vehicle/wheelbase", "publish_tf", "encoders/counter_bits", "odometry/axles", "initial_pose/covariance",
      "noise"}},
    {"/out_of_range",
     true,
     {set("vehicle/wheelbase", -1.2), set("vehicle/track/front", 0.0), set("encoders/counter_bits", 7),
      set("gains/rear/k_b", 3.0), set("noise/wheel", -0.1), set("max_speed", 0.0), set("steering_limit", 1.4),
      set("steering/front/scale", 0.0), set("steering_wait", -1)},
     {"vehicle/wheelbase", "vehicle/track/front", "encoders/counter_bits", "gains/rear/k_b", "noise/wheel",
      "max_speed", "steering_limit", "steering/front/scale", "steering_wait"}},
    {"/not_finite",
     true,
     {set("vehicle/wheelbase", std::nan("")), set("noise/lateral", std::numeric_limits<double>::infinity()),
      set("initial_pose/x", "nan"), set("gains/front/k_r", "1e-3x")},
     {"vehicle/wheelbase", "noise/lateral", "initial_pose/x", "gains/front/k_r"}},
    {"/against_each_other",
     true,
     {set("odom_frame", "base_link"), set("odometry/motion", "paper"), set("vehicle/hub_offset/front", 0.7)},
     {"odom_frame", "odometry/motion", "vehicle/hub_offset/front"}},
};

class BadParameters : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadParameters, P1_P2_P3_all_are_listed_at_once) {
  const BadFile& file = GetParam();
  if (file.minimal_vehicle) setMinimalVehicle(file.node);
  for (const Setting& setting : file.settings) setting(file.node);
  ChildProcess node(commandOf(file.node));
  EXPECT_EQ(node.waitForExit(), 1);
  EXPECT_THAT(node.output(), HasSubstr("does not run"));
  for (const std::string& name : file.wrong) EXPECT_THAT(node.output(), HasSubstr(name + ": "));
}

INSTANTIATE_TEST_SUITE_P(Table, BadParameters, ::testing::ValuesIn(kBadFiles),
                         [](const auto& row) { return row.param.node.substr(1); });

/// Starts, and ends with 0 when interrupted.
void expectRuns(ChildProcess& node, const std::string& name) {
  EXPECT_TRUE(waitFor([&] { return alive(name) != 0; })) << node.output();
  node.interrupt();
  EXPECT_EQ(node.waitForExit(), 0) << node.output();
}

TEST(Parameters, P2_numbers_may_be_text) {
  setMinimalVehicle("/text");
  ros::param::set("/text/noise/wheel", "1e-3");
  ros::param::set("/text/vehicle/wheelbase", "2");
  ChildProcess node(commandOf("/text"));
  expectRuns(node, "/text");
  EXPECT_THAT(node.output(), ::testing::Not(HasSubstr("noise/wheel"))) << "nothing to warn of";
}

TEST(Parameters, P4_misspelt_names_are_warned_of_with_the_nearest) {
  setMinimalVehicle("/misspelt");
  ros::param::set("/misspelt/noise/whel", 0.01);
  ros::param::set("/misspelt/max_sped", 3.0);
  ros::param::set("/misspelt/vehicle/counter_bits", 16);
  ChildProcess node(commandOf("/misspelt"));
  for (const char* pair :
       {"noise/whel: unknown parameter, not used; the nearest known one is noise/wheel",
        "max_sped: unknown parameter, not used; the nearest known one is max_speed",
        "vehicle/counter_bits: unknown parameter, not used; the nearest known one is encoders/counter_bits"})
    EXPECT_TRUE(node.waitForOutput(pair)) << node.output();
  expectRuns(node, "/misspelt");
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "node_parameters_test");
}
