// Values that stop the start: each is named with what it is and what is allowed, all of them at once.

#include "vehicle_file.hpp"

#include <gmock/gmock.h>

#include <algorithm>

namespace bs_car_odometry::testing {
namespace {

using ::testing::HasSubstr;

struct BadValue {
  Overrides set;        ///< on top of a good vehicle file
  std::string name;     ///< the parameter that the message names
  std::string value;    ///< as the message shows it
  std::string allowed;  ///< part of what the message says is allowed
};

const std::vector<BadValue> kBadValues{
    // wrong type
    {{{"vehicle/wheelbase", "long"}},
     "vehicle/wheelbase",
     "'long' is not a number",
     "above 0, at most 100 [m]"},
    {{{"vehicle/wheelbase", "[1.2]"}}, "vehicle/wheelbase", "'[1.2]' is not a number", "above 0"},
    {{{"vehicle/wheelbase", ""}}, "vehicle/wheelbase", "(no value)", "above 0"},
    {{{"vehicle/wheelbase", "1.2 m"}}, "vehicle/wheelbase", "'1.2 m' is not a number", "above 0"},
    {{{"max_gap", "0x1F"}}, "max_gap", "'0x1F'", "above 0, at most 3600 [s]"},
    {{{"max_gap", "true"}}, "max_gap", "'true'", "above 0"},
    {{{"publish_tf", "1"}}, "publish_tf", "'1'", "true or false"},
    {{{"publish_tf", "{a: 1}"}}, "publish_tf", "{a: 1}", "true or false"},
    {{{"base_frame", "[base_link]"}}, "base_frame", "[base_link]", "the name of a frame"},
    {{{"encoders/counter_bits", "16.5"}},
     "encoders/counter_bits",
     "'16.5'",
     "0, or a whole number from 8 to 32"},
    {{{"vehicle/rear_steering/coefficients", "-1"}},
     "vehicle/rear_steering/coefficients",
     "'-1'",
     "a list of 1 to 16 numbers"},
    {{{"vehicle/rear_steering/coefficients", "[0, x]"}},
     "vehicle/rear_steering/coefficients",
     "'x', which is not a number",
     "a list of 1 to 16 numbers"},
    {{{"vehicle", "3"}}, "vehicle", "'3'", "a map of the parameters in vehicle"},
    // not finite
    {{{"noise/wheel", ".nan"}}, "noise/wheel", "'.nan' is not finite", "from 0 to 10 [m/sqrt(m)]"},
    {{{"noise/wheel", "nan"}}, "noise/wheel", "'nan' is not finite", "from 0"},
    {{{"max_speed", ".inf"}}, "max_speed", "'.inf' is not finite", "above 0"},
    {{{"max_speed", "1e999"}}, "max_speed", "'1e999' is not finite", "above 0"},
    {{{"initial_pose/x", "-Infinity"}}, "initial_pose/x", "'-Infinity' is not finite", "from -1000000000"},
    // out of range
    {{{"vehicle/wheelbase", "0"}}, "vehicle/wheelbase", "'0' is out of range", "above 0"},
    {{{"vehicle/track/front", "-1.2"}}, "vehicle/track/front", "'-1.2'", "above 0"},
    {{{"vehicle/track", "0"}}, "vehicle/track/rear", "'0'", "above 0"},
    {{{"noise/steering/std", "-0.001"}}, "noise/steering/std", "'-0.001'", "from 0"},
    {{{"noise/steering/correlation_length", "0"}}, "noise/steering/correlation_length", "'0'", "above 0"},
    {{{"steering_limit", "1.31"}}, "steering_limit", "'1.31'", "at most 1.3 [rad]"},
    {{{"gains/rear/k_b", "0.49"}}, "gains/rear/k_b", "'0.49'", "from 0.5 to 2"},
    {{{"gains/front/k_r", "2.1"}}, "gains/front/k_r", "'2.1'", "from 0.5 to 2"},
    {{{"steering/front/scale", "0"}}, "steering/front/scale", "'0' is zero", "not 0"},
    {{{"encoders/counter_bits", "7"}}, "encoders/counter_bits", "'7'", "8 to 32"},
    {{{"encoders/counter_bits", "64"}}, "encoders/counter_bits", "'64'", "8 to 32"},
    {{{"laser/yaw", "90"}}, "laser/yaw", "'90'", "[rad]"},
    {{{"max_future", "-1"}}, "max_future", "'-1'", "from 0"},
    {{{"calibration/prior/k_r", "0"}}, "calibration/prior/k_r", "'0'", "above 0"},
    {{{"initial_pose/covariance", "[1, 0, 0]"}}, "initial_pose/covariance", "has 3 numbers", "9 numbers"},
    {{{"initial_pose/covariance", "[1, 0.1, 0, 0, 1, 0, 0, 0, 1]"}},
     "initial_pose/covariance",
     "is no covariance",
     "symmetric positive semidefinite"},
    {{{"initial_pose/covariance", "[1, 2, 0, 2, 1, 0, 0, 0, 1]"}},
     "initial_pose/covariance",
     "is no covariance",
     "symmetric positive semidefinite"},
    // unknown words
    {{{"odometry/axles", "all"}}, "odometry/axles", "'all'", "both, front or rear"},
    {{{"odometry/motion", "Exact"}}, "odometry/motion", "'Exact'", "exact or paper"},
    {{{"input", "[]"}}, "input", "'[]'", "wheel_ticks or joint_states"},
    {{{"stamp_source", "now"}}, "stamp_source", "'now'", "header or receipt"},
    {{{"calibration/estimate", "[gains, gain]"}}, "calibration/estimate", "'gain'", "steering_offset"},
    {{{"calibration/estimate", "[gains, gains]"}}, "calibration/estimate", "twice", "steering_offset"},
    {{{"calibration/estimate", "[]"}}, "calibration/estimate", "is empty", "steering_offset"},
    // calibrations
    {{{"calibration_file", "[car.yaml]"}}, "calibration_file", "is not a text", "the path of a file"},
    {{{"accept_calibration", "car.yaml"}},
     "accept_calibration",
     "is neither true nor false",
     "true or false"},
    {{{"require_calibration", "car.yaml"}},
     "require_calibration",
     "is neither true nor false",
     "true or false"},
    {{{"odometry/uncertainty", "montecarlo"}},
     "odometry/uncertainty",
     "'montecarlo' is not known",
     "monte_carlo"},
    {{{"odometry/particles/count", "99"}}, "odometry/particles/count", "'99'", "from 100 to 1000000"},
    {{{"odometry/particles/seed", "0.5"}}, "odometry/particles/seed", "is not a whole number", "from 0"},
    {{{"odometry/particles/threads", "0"}}, "odometry/particles/threads", "is out of range", "from 1 to 64"},
    // distributions
    {{{"noise/wheel", "[0.1]"}},
     "noise/wheel",
     "'[0.1]' is not a number",
     "or a map with a distribution (gaussian, "},
    {{{"max_gap", "{distribution: uniform, half_width: 0.1}"}}, "max_gap", "is not a number", "above 0"},
    {{{"noise/steering/correlation_length", "{distribution: uniform, half_width: 0.1}"}},
     "noise/steering/correlation_length",
     "is not a number",
     "above 0, at most 1000 [m]"},
    {{{"noise/wheel", "{}"}},
     "noise/wheel/distribution",
     "is missing",
     "gaussian, uniform, triangular or student_t"},
    {{{"noise/wheel", "{half_width: 0.1}"}}, "noise/wheel/distribution", "is missing", "student_t"},
    {{{"noise/wheel", "{distribution: normal, std: 0.1}"}},
     "noise/wheel/distribution",
     "'normal' is not known",
     "gaussian, uniform, triangular or student_t"},
    {{{"noise/wheel", "{distribution: [uniform], half_width: 0.1}"}},
     "noise/wheel/distribution",
     "'[uniform]' is not known",
     "gaussian"},
    {{{"noise/wheel", "{distribution: , half_width: 0.1}"}},
     "noise/wheel/distribution",
     "(no value) is not known",
     "gaussian"},
    {{{"noise/wheel", "{distribution: uniform, hlaf_width: 0.1}"}},
     "noise/wheel/hlaf_width",
     "is not known",
     "distribution or half_width; the nearest is half_width"},
    {{{"noise/wheel", "{distirbution: uniform, half_width: 0.1}"}},
     "noise/wheel/distirbution",
     "is not known",
     "; the nearest is distribution"},
    {{{"noise/wheel", "{distribution: student_t, scale: 0.1, degree_of_freedom: 5}"}},
     "noise/wheel/degree_of_freedom",
     "is not known",
     "; the nearest is degrees_of_freedom"},
    {{{"noise/wheel", "{distribution: uniform, half_width: 0.1, truncation: 0.1}"}},
     "noise/wheel/truncation",
     "is not known",
     "distribution or half_width"},
    {{{"noise/wheel", "{distribution: uniform, half_width: 0.1, half_width: 0.1}"}},
     "noise/wheel/half_width",
     "is given twice",
     "once"},
    {{{"noise/wheel", "{distribution: uniform}"}},
     "noise/wheel/half_width",
     "is missing",
     "from 0 to 10 [m/sqrt(m)]"},
    {{{"noise/wheel", "{distribution: gaussian, truncation: 0.1}"}},
     "noise/wheel/std",
     "is missing",
     "from 0"},
    {{{"noise/wheel", "{distribution: triangular, half_width: -0.1}"}},
     "noise/wheel/half_width",
     "'-0.1' is out of range",
     "from 0 to 10 [m/sqrt(m)]"},
    {{{"noise/wheel", "{distribution: triangular, half_width: 0.1 m}"}},
     "noise/wheel/half_width",
     "'0.1 m' is not a number",
     "from 0"},
    {{{"noise/wheel", "{distribution: gaussian, std: .nan}"}},
     "noise/wheel/std",
     "'.nan' is not finite",
     "from 0"},
    {{{"noise/wheel", "{distribution: gaussian, std: {distribution: gaussian, std: 1}}"}},
     "noise/wheel/std",
     "is not a number",
     "from 0"},
    {{{"noise/wheel", "{distribution: gaussian, std: 0.1, truncation: 0.04}"}},
     "noise/wheel/truncation",
     "'0.04' is out of range",
     "from 0.05 to 10 [m/sqrt(m)]"},
    {{{"noise/wheel", "{distribution: gaussian, std: 1e-13, truncation: 1}"}},
     "noise/wheel/truncation",
     "'1' is out of range",
     "from 5e-14 to 0.1"},
    {{{"noise/wheel", "{distribution: gaussian, std: 0, truncation: 0}"}},
     "noise/wheel/truncation",
     "'0' is out of range",
     "above 0"},
    {{{"noise/wheel", "{distribution: gaussian, std: 0.1, truncation: .inf}"}},
     "noise/wheel/truncation",
     "'.inf' is not finite",
     "from 0.05"},
    {{{"noise/wheel", "{distribution: student_t, scale: 0.1}"}},
     "noise/wheel/degrees_of_freedom",
     "is missing",
     "above 2, at most 1000000, or from 1 with a truncation"},
    {{{"noise/wheel", "{distribution: student_t, scale: 0.1, degrees_of_freedom: 2}"}},
     "noise/wheel/degrees_of_freedom",
     "'2' is out of range",
     "above 2"},
    {{{"noise/wheel", "{distribution: student_t, scale: 0.1, degrees_of_freedom: 0.9, truncation: 1}"}},
     "noise/wheel/degrees_of_freedom",
     "'0.9' is out of range",
     "from 1 to 1000000"},
    {{{"noise/systematic/k_r", "{distribution: student_t, scale: 0.9, degrees_of_freedom: 2.5}"}},
     "noise/systematic/k_r",
     "has a standard deviation of 2.01246118, which is out of range",
     "from 0 to 1"},
    {{{"noise/steering/std", "{distribution: uniform, half_width: 2}"}},
     "noise/steering/std/half_width",
     "'2' is out of range",
     "[rad]"},
    // several parameters that do not go together
    {{{"base_frame", ""}}, "base_frame", "''", "the name of a frame"},
    {{{"odom_frame", "/"}}, "odom_frame", "''", "the name of a frame"},
    {{{"odom_frame", "/base_link"}}, "odom_frame", "'base_link'", "different from base_frame"},
    {{{"vehicle/hub_offset/rear", "0.6"}},
     "vehicle/hub_offset/rear",
     "'0.6'",
     "half of vehicle/track/rear (1.2)"},
    {{{"vehicle/rear_steering/coefficients", "[0, -1.25]"}},
     "vehicle/rear_steering/coefficients",
     "at a front angle of -1.3 is 1.625",
     "steering_limit (1.3)"},
    {{{"encoders/metres_per_tick", "{front_left: 0, front_right: 0, rear_left: 0, rear_right: 1}"}},
     "encoders/metres_per_tick",
     "only 1 wheel(s)",
     "at least two wheels"},
    {{{"encoders/metres_per_tick/rear_left", "0"}, {"odometry/axles", "rear"}},
     "encoders/metres_per_tick/rear_left",
     "'0'",
     "not 0, since odometry/axles is rear"},
    {{{"odometry/motion", "paper"}}, "odometry/motion", "'paper'", "odometry/axles front or rear"},
    {{{"odometry/shortened_track", "false"}, {"vehicle/axle_geometry", "pivot"}},
     "odometry/shortened_track",
     "'false'",
     "odometry/axles front or rear"},
    {{{"odometry/shortened_track", "false"}, {"odometry/axles", "front"}},
     "odometry/shortened_track",
     "'false'",
     "vehicle/axle_geometry pivot, or odometry/motion paper"},
    {{{"calibration/method", "paper"}},
     "calibration/method",
     "'paper' does not go with odometry/axles both",
     "joint, or odometry/axles front or rear"},
    {{{"calibration/method", "paper"},
      {"odometry/axles", "rear"},
      {"calibration/estimate", "[gains, laser_mount]"}},
     "calibration/estimate",
     "is not what calibration/method paper finds",
     "[gains], or calibration/method joint"},
    {{{"calibration/method", "paper"},
      {"odometry/axles", "front"},
      {"calibration/gain_random_walk", "0.001"}},
     "calibration/gain_random_walk",
     "'0.001' does not go with calibration/method paper",
     "0, or calibration/method joint"},
    {{{"laser/frame", "laser"}, {"laser/y", "0.2"}}, "laser/y", "'0.2'", "0, or an empty laser/frame"},
    {{{"input", "joint_states"}}, "joints/rear_right", "''", "the name of a joint"},
    {{{"input", "joint_states"}}, "joints/front_steering", "''", "the name of a joint"},
    {{{"input", "joint_states"}, {"joints/front_left", "a"}, {"joints/rear_left", "a"}},
     "joints/rear_left",
     "'a' is joints/front_left as well",
     "a joint of its own"},
    {{{"joints/front_steering", "[a, b, c]"}},
     "joints/front_steering",
     "has 3 entries",
     "left and the right"},
};

TEST(BadValues, eachIsNamedWithItsValueAndWhatIsAllowed) {
  EXPECT_GE(kBadValues.size(), 40u);
  for (const BadValue& bad : kBadValues) {
    SCOPED_TRACE(bad.set.front().first + " = " + bad.set.front().second);
    const std::string message = "\n" + errorOf(kMinimalVehicle, bad.set);
    const std::size_t begin = message.find("\n" + bad.name + ": ");
    ASSERT_NE(begin, std::string::npos) << message;
    const std::string line = message.substr(begin + 1, message.find('\n', begin + 1) - begin - 1);
    const std::size_t separator = line.find("; allowed: ");
    ASSERT_NE(separator, std::string::npos) << line;
    EXPECT_THAT(line.substr(0, separator), HasSubstr(bad.value));
    EXPECT_THAT(line.substr(separator), HasSubstr(bad.allowed));
  }
}

TEST(BadValues, P1_everyMissingOneIsListedAtOnce) {
  const std::string message = errorOf("publish_tf: true");
  for (const char* name : {"vehicle/wheelbase", "vehicle/track/front", "vehicle/track/rear",
                           "encoders/metres_per_tick/front_left", "encoders/metres_per_tick/front_right",
                           "encoders/metres_per_tick/rear_left", "encoders/metres_per_tick/rear_right"})
    EXPECT_THAT(message, HasSubstr(std::string(name) + ": is missing; allowed: "));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 6) << message;
}

TEST(BadValues, P3_missingMistypedAndOutOfRangeAreListedTogether) {
  const std::string message = errorOf(
      "vehicle: {track: {front: 1.2, rear: wide}}\n"
      "encoders: {metres_per_tick: {front_left: 1e-4, front_right: 1e-4, rear_left: 1e-4, rear_right: "
      ".nan}}\n"
      "odometry: {axles: none, motion: paper}\n"
      "max_gap: -1\n"
      "odom_frame: base_link\n");
  for (const char* line : {"vehicle/wheelbase: is missing", "vehicle/track/rear: 'wide'",
                           "encoders/metres_per_tick/rear_right: '.nan'", "odometry/axles: 'none'",
                           "max_gap: '-1'", "odom_frame: 'base_link'"})
    EXPECT_THAT(message, HasSubstr(line));
  // What follows from a wrong value is not held against the user as well.
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 5) << message;
}

TEST(BadValues, aNameGivenTwiceIsNoGuess) {
  EXPECT_THAT(errorOf(std::string(kMinimalVehicle) + "max_gap: 1\nmax_gap: 2\n"),
              HasSubstr("max_gap: is given twice"));
}

TEST(BadFiles, areNamedWithWhatIsWrong) {
  EXPECT_THAT(errorOf(""), HasSubstr("is empty"));
  EXPECT_THAT(errorOf("# nothing\n"), HasSubstr("is empty"));
  EXPECT_THAT(errorOf("- a\n- b\n"), HasSubstr("is not a map"));
  EXPECT_THAT(errorOf("just words"), HasSubstr("is not a map"));
  EXPECT_THAT(errorOf("vehicle: {wheelbase: 1.2"), HasSubstr("not YAML"));
  EXPECT_THAT(errorOf(std::string(70000, '#')), HasSubstr("64 kB"));
}

TEST(BadFiles, aMissingOneAndAFolderAreNamed) {
  try {
    loadParameterFiles({"/nowhere/car.yaml"});
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/car.yaml: cannot be opened");
  }
  EXPECT_THROW(loadParameterFiles({"/tmp"}), ParameterError);
}

}  // namespace
}  // namespace bs_car_odometry::testing
