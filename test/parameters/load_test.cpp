// Good vehicle files: defaults, forms of numbers, overrides.

#include "vehicle_file.hpp"

#include <gmock/gmock.h>

#include <set>

namespace bs_car_odometry::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Every parameter with its default (README.md).
const char* const kEveryParameter = R"(
base_frame: base_link
odom_frame: odom
publish_tf: true
input: wheel_ticks
accept_calibration: false
calibration_file: ""
require_calibration: false
output: ""
vehicle:
  name: ""
  wheelbase: 1.20
  track: {front: 1.20, rear: 1.20}
  base_link_x: 0.0
  hub_offset: {front: 0.0, rear: 0.0}
  axle_geometry: ackermann
  rear_steering:
    source: polynomial
    coefficients: [0.0, -1.0]
encoders:
  counter_bits: 32
  metres_per_tick: {front_left: 1.0e-4, front_right: 1.0e-4, rear_left: 1.0e-4, rear_right: 1.0e-4}
joints: {front_left: "", front_right: "", rear_left: "", rear_right: "", front_steering: [], rear_steering: []}
steering:
  front: {scale: 1.0, offset: 0.0}
  rear:  {scale: 1.0, offset: 0.0}
gains:
  front: {k_r: 1.0, k_l: 1.0, k_b: 1.0}
  rear:  {k_r: 1.0, k_l: 1.0, k_b: 1.0}
odometry:
  axles: both
  motion: exact
  shortened_track: true
  fault_detection: true
  uncertainty: first_order
  systematic_rule: degree_five
  particles: {count: 10000, seed: 1, threads: 1, published: 500}
noise:
  wheel: 0.005
  steering: {std: 0.003, correlation_length: 0.1}
  lateral: 0.0005
  rear_law: 0.001
  systematic: {k_r: 0.01, k_l: 0.01, k_b: 0.02, steering_offset: 0.003}
calibration:
  method: joint
  estimate: [gains]
  prior: {k_r: 0.05, k_l: 0.05, k_b: 0.05, steering_offset: 0.02, steering_scale: 0.05}
  gain_random_walk: 0.0
  allow_partial: false
  straight_limit: 0.05
laser: {frame: "", x: 0.0, y: 0.0, yaw: 0.0, time_offset: 0.0}
initial_pose: {x: 0.0, y: 0.0, yaw: 0.0, covariance: [0, 0, 0, 0, 0, 0, 0, 0, 0]}
laser_sigma: {position: 0.02, yaw: 0.005}
max_speed: 40.0
max_gap: 0.5
max_future: 0.1
steering_limit: 1.3
max_steering_age: 0.2
steering_wait: 0.02
stamp_source: header
unmeasured_variance: 0.0
relative_motion: {history: 60.0}
)";

void collectPaths(const YAML::Node& map, const std::string& group, std::set<std::string>& paths) {
  for (const auto& child : map) {
    const std::string path = group + child.first.as<std::string>();
    if (child.second.IsMap()) {
      collectPaths(child.second, path + "/", paths);
    } else {
      paths.insert(path);
    }
  }
}

TEST(EveryParameter, isKnownAndNoOtherIs) {
  std::set<std::string> documented;
  collectPaths(YAML::Load(kEveryParameter), "", documented);
  const std::vector<std::string> paths = parameterPaths();
  EXPECT_EQ(std::set<std::string>(paths.begin(), paths.end()), documented);
  EXPECT_EQ(paths.size(), documented.size());
  EXPECT_THAT(load(kEveryParameter).warnings, IsEmpty());
}

void expectDefaults(const Parameters& p) {
  EXPECT_EQ(p.base_frame, "base_link");
  EXPECT_EQ(p.odom_frame, "odom");
  EXPECT_TRUE(p.publish_tf);
  EXPECT_EQ(p.input, InputSource::kWheelTicks);
  EXPECT_FALSE(p.accept_calibration || p.require_calibration);
  EXPECT_EQ(p.calibration_file + p.output + p.vehicle.name, "");
  EXPECT_EQ(p.vehicle.base_link_x, 0.0);
  EXPECT_EQ(p.vehicle.axle_geometry, AxleGeometry::kAckermann);
  EXPECT_EQ(p.vehicle.rear_steering.source, RearSteering::Source::kPolynomial);
  EXPECT_THAT(p.vehicle.rear_steering.coefficients, ElementsAre(0.0, -1.0));
  EXPECT_EQ(p.vehicle.counter_bits, 32);
  for (const Axle axle : kAllAxles) {
    EXPECT_EQ(p.vehicle.hub_offset[axle], 0.0);
    EXPECT_EQ(p.vehicle.steering[axle].scale, 1.0);
    EXPECT_EQ(p.vehicle.steering[axle].offset, 0.0);
    EXPECT_EQ(p.vehicle.gains[axle].k_r, 1.0);
    EXPECT_EQ(p.vehicle.gains[axle].k_l, 1.0);
    EXPECT_EQ(p.vehicle.gains[axle].k_b, 1.0);
    EXPECT_THAT(p.joints.steering[axle], IsEmpty());
  }
  for (const Wheel wheel : kAllWheels) EXPECT_EQ(p.joints.wheels[wheel], "");
}

void expectDefaultOptions(const Parameters& p) {
  EXPECT_EQ(p.odometry.axles, AxleSelection::kBoth);
  EXPECT_EQ(p.odometry.motion, Motion::kExact);
  EXPECT_TRUE(p.odometry.shortened_track);
  EXPECT_TRUE(p.odometry.fault_detection);
  EXPECT_EQ(p.odometry.uncertainty, Uncertainty::kFirstOrder);
  EXPECT_EQ(p.odometry.systematic_rule, SystematicRule::kDegreeFive);
  EXPECT_EQ(p.odometry.particles.count, 10000);
  EXPECT_EQ(p.odometry.particles.seed, 1);
  EXPECT_EQ(p.odometry.particles.threads, 1);
  EXPECT_EQ(p.odometry.particles.published, 500);
  EXPECT_EQ(p.noise.wheel.std(), 0.005);
  EXPECT_EQ(p.noise.steering.angle.std(), 0.003);
  EXPECT_EQ(p.noise.steering.correlation_length, 0.1);
  EXPECT_EQ(p.noise.lateral.std(), 0.0005);
  EXPECT_EQ(p.noise.rear_law.std(), 0.001);
  EXPECT_EQ(p.noise.systematic.k_r.std(), 0.01);
  EXPECT_EQ(p.noise.systematic.k_l.std(), 0.01);
  EXPECT_EQ(p.noise.systematic.k_b.std(), 0.02);
  EXPECT_EQ(p.noise.systematic.steering_offset.std(), 0.003);
  EXPECT_EQ(p.calibration.method, CalibrationMethod::kJoint);
  EXPECT_THAT(p.calibration.estimate, ElementsAre("gains"));
  EXPECT_EQ(p.calibration.prior.k_r, 0.05);
  EXPECT_EQ(p.calibration.prior.k_l, 0.05);
  EXPECT_EQ(p.calibration.prior.k_b, 0.05);
  EXPECT_EQ(p.calibration.prior.steering_offset, 0.02);
  EXPECT_EQ(p.calibration.prior.steering_scale, 0.05);
  EXPECT_EQ(p.calibration.gain_random_walk, 0.0);
  EXPECT_FALSE(p.calibration.allow_partial);
  EXPECT_EQ(p.calibration.straight_limit, 0.05);
}

void expectDefaultInputs(const Parameters& p) {
  EXPECT_EQ(p.laser.frame, "");
  EXPECT_EQ(p.laser.x, 0.0);
  EXPECT_EQ(p.laser.y, 0.0);
  EXPECT_EQ(p.laser.yaw, 0.0);
  EXPECT_EQ(p.laser.time_offset, 0.0);
  EXPECT_EQ(p.laser_sigma.position, 0.02);
  EXPECT_EQ(p.laser_sigma.yaw, 0.005);
  EXPECT_EQ(p.initial_pose.x, 0.0);
  EXPECT_EQ(p.initial_pose.y, 0.0);
  EXPECT_EQ(p.initial_pose.yaw, 0.0);
  EXPECT_EQ(p.initial_pose.covariance, Eigen::Matrix3d::Zero());
  EXPECT_EQ(p.limits.max_speed, 40.0);
  EXPECT_EQ(p.limits.max_gap, std::chrono::milliseconds(500));
  EXPECT_EQ(p.limits.max_future, std::chrono::milliseconds(100));
  EXPECT_EQ(p.limits.steering_limit, 1.3);
  EXPECT_EQ(p.limits.max_steering_age, std::chrono::milliseconds(200));
  EXPECT_EQ(p.limits.steering_wait, std::chrono::milliseconds(20));
  EXPECT_EQ(p.stamp_source, StampSource::kHeader);
  EXPECT_EQ(p.unmeasured_variance, 0.0);
  EXPECT_EQ(p.relative_motion.history, std::chrono::seconds(60));
}

TEST(Defaults, areTheDocumentedOnes) {
  for (const char* text : {kMinimalVehicle, kEveryParameter}) {
    const Parameters p = load(text).parameters;
    expectDefaults(p);
    expectDefaultOptions(p);
    expectDefaultInputs(p);
    EXPECT_EQ(p.vehicle.wheelbase, 1.2);
    EXPECT_EQ(p.vehicle.track.front, 1.2);
    EXPECT_EQ(p.vehicle.track.rear, 1.2);
    for (const Wheel wheel : kAllWheels) EXPECT_EQ(p.vehicle.metres_per_tick[wheel], 1e-4);
  }
}

struct NumberMember {
  std::string path;
  double value;  ///< allowed, and not the default
  double (*member)(const Parameters&);
};

const std::vector<NumberMember> kNumbers{
    {"vehicle/wheelbase", 2.5, [](const Parameters& p) { return p.vehicle.wheelbase; }},
    {"vehicle/track/front", 1.5, [](const Parameters& p) { return p.vehicle.track.front; }},
    {"vehicle/track/rear", 1.5, [](const Parameters& p) { return p.vehicle.track.rear; }},
    {"vehicle/base_link_x", -0.5, [](const Parameters& p) { return p.vehicle.base_link_x; }},
    {"vehicle/hub_offset/front", 0.1, [](const Parameters& p) { return p.vehicle.hub_offset.front; }},
    {"vehicle/hub_offset/rear", 0.1, [](const Parameters& p) { return p.vehicle.hub_offset.rear; }},
    {"encoders/counter_bits", 16, [](const Parameters& p) { return double(p.vehicle.counter_bits); }},
    {"encoders/metres_per_tick/front_left", 0.5,
     [](const Parameters& p) { return p.vehicle.metres_per_tick[Wheel::kFrontLeft]; }},
    {"encoders/metres_per_tick/front_right", 0.5,
     [](const Parameters& p) { return p.vehicle.metres_per_tick[Wheel::kFrontRight]; }},
    {"encoders/metres_per_tick/rear_left", 0.5,
     [](const Parameters& p) { return p.vehicle.metres_per_tick[Wheel::kRearLeft]; }},
    {"encoders/metres_per_tick/rear_right", 0.5,
     [](const Parameters& p) { return p.vehicle.metres_per_tick[Wheel::kRearRight]; }},
    {"steering/front/scale", -2, [](const Parameters& p) { return p.vehicle.steering.front.scale; }},
    {"steering/front/offset", 0.1, [](const Parameters& p) { return p.vehicle.steering.front.offset; }},
    {"steering/rear/scale", -2, [](const Parameters& p) { return p.vehicle.steering.rear.scale; }},
    {"steering/rear/offset", 0.1, [](const Parameters& p) { return p.vehicle.steering.rear.offset; }},
    {"gains/front/k_r", 1.1, [](const Parameters& p) { return p.vehicle.gains.front.k_r; }},
    {"gains/front/k_l", 1.1, [](const Parameters& p) { return p.vehicle.gains.front.k_l; }},
    {"gains/front/k_b", 1.1, [](const Parameters& p) { return p.vehicle.gains.front.k_b; }},
    {"gains/rear/k_r", 1.1, [](const Parameters& p) { return p.vehicle.gains.rear.k_r; }},
    {"gains/rear/k_l", 1.1, [](const Parameters& p) { return p.vehicle.gains.rear.k_l; }},
    {"gains/rear/k_b", 1.1, [](const Parameters& p) { return p.vehicle.gains.rear.k_b; }},
    {"noise/wheel", 0.5, [](const Parameters& p) { return p.noise.wheel.std(); }},
    {"noise/steering/std", 0.5, [](const Parameters& p) { return p.noise.steering.angle.std(); }},
    {"noise/steering/correlation_length", 0.5,
     [](const Parameters& p) { return p.noise.steering.correlation_length; }},
    {"noise/lateral", 0.5, [](const Parameters& p) { return p.noise.lateral.std(); }},
    {"noise/rear_law", 0.5, [](const Parameters& p) { return p.noise.rear_law.std(); }},
    {"noise/systematic/k_r", 0.5, [](const Parameters& p) { return p.noise.systematic.k_r.std(); }},
    {"noise/systematic/k_l", 0.5, [](const Parameters& p) { return p.noise.systematic.k_l.std(); }},
    {"noise/systematic/k_b", 0.5, [](const Parameters& p) { return p.noise.systematic.k_b.std(); }},
    {"noise/systematic/steering_offset", 0.5,
     [](const Parameters& p) { return p.noise.systematic.steering_offset.std(); }},
    {"calibration/prior/k_r", 0.5, [](const Parameters& p) { return p.calibration.prior.k_r; }},
    {"calibration/prior/k_l", 0.5, [](const Parameters& p) { return p.calibration.prior.k_l; }},
    {"calibration/prior/k_b", 0.5, [](const Parameters& p) { return p.calibration.prior.k_b; }},
    {"calibration/prior/steering_offset", 0.5,
     [](const Parameters& p) { return p.calibration.prior.steering_offset; }},
    {"calibration/prior/steering_scale", 0.5,
     [](const Parameters& p) { return p.calibration.prior.steering_scale; }},
    {"calibration/gain_random_walk", 0.5, [](const Parameters& p) { return p.calibration.gain_random_walk; }},
    {"calibration/straight_limit", 0.5, [](const Parameters& p) { return p.calibration.straight_limit; }},
    {"laser/x", 0.5, [](const Parameters& p) { return p.laser.x; }},
    {"laser/y", 0.5, [](const Parameters& p) { return p.laser.y; }},
    {"laser/yaw", 0.5, [](const Parameters& p) { return p.laser.yaw; }},
    {"laser/time_offset", -0.5, [](const Parameters& p) { return p.laser.time_offset; }},
    {"laser_sigma/position", 0.5, [](const Parameters& p) { return p.laser_sigma.position; }},
    {"laser_sigma/yaw", 0.5, [](const Parameters& p) { return p.laser_sigma.yaw; }},
    {"initial_pose/x", 0.5, [](const Parameters& p) { return p.initial_pose.x; }},
    {"initial_pose/y", 0.5, [](const Parameters& p) { return p.initial_pose.y; }},
    {"initial_pose/yaw", 0.5, [](const Parameters& p) { return p.initial_pose.yaw; }},
    {"max_speed", 5, [](const Parameters& p) { return p.limits.max_speed; }},
    {"max_gap", 0.25, [](const Parameters& p) { return toSeconds(p.limits.max_gap); }},
    {"max_future", 0.25, [](const Parameters& p) { return toSeconds(p.limits.max_future); }},
    {"steering_limit", 0.5, [](const Parameters& p) { return p.limits.steering_limit; }},
    {"max_steering_age", 0.25, [](const Parameters& p) { return toSeconds(p.limits.max_steering_age); }},
    {"steering_wait", 0.25, [](const Parameters& p) { return toSeconds(p.limits.steering_wait); }},
    {"unmeasured_variance", 0.5, [](const Parameters& p) { return p.unmeasured_variance; }},
    {"relative_motion/history", 2.5,
     [](const Parameters& p) { return toSeconds(p.relative_motion.history); }},
};

TEST(Values, everyNumberReachesItsMemberAndNoOther) {
  const Parameters defaults = load(kMinimalVehicle).parameters;
  for (const NumberMember& set : kNumbers) {
    const Parameters p = load(kMinimalVehicle, {{set.path, std::to_string(set.value)}}).parameters;
    for (const NumberMember& number : kNumbers)
      EXPECT_EQ(number.member(p), number.path == set.path ? set.value : number.member(defaults))
          << number.path << " after setting " << set.path;
  }
}

TEST(Values, wordsListsAndTextsReachTheirMembers) {
  const Parameters p =
      load(kMinimalVehicle,
           {{"initial_pose/covariance", "[4, 1, 0, 1, 5, 0.5, 0, 0.5, 6]"},
            {"vehicle/name", "car 7"},
            {"vehicle/axle_geometry", "pivot"},
            {"vehicle/rear_steering", "{source: measured, coefficients: [0.01, 0, 0.5]}"},
            {"joints", "{rear_left: wheel, front_steering: [l, r], rear_steering: single}"},
            {"odometry", "{axles: rear, motion: paper, shortened_track: false, fault_detection: false}"},
            {"calibration", "{method: paper, allow_partial: true}"},
            {"publish_tf", "false"},
            {"output", "cal.yaml"},
            {"stamp_source", "receipt"}})
          .parameters;
  EXPECT_EQ(p.initial_pose.covariance, (Eigen::Matrix3d() << 4, 1, 0, 1, 5, 0.5, 0, 0.5, 6).finished());
  EXPECT_EQ(p.vehicle.name, "car 7");
  EXPECT_EQ(p.vehicle.axle_geometry, AxleGeometry::kPivot);
  EXPECT_EQ(p.vehicle.rear_steering.source, RearSteering::Source::kMeasured);
  EXPECT_THAT(p.vehicle.rear_steering.coefficients, ElementsAre(0.01, 0.0, 0.5));
  EXPECT_EQ(p.joints.wheels[Wheel::kRearLeft], "wheel");
  EXPECT_THAT(p.joints.steering.front, ElementsAre("l", "r"));
  EXPECT_THAT(p.joints.steering.rear, ElementsAre("single"));
  EXPECT_EQ(p.odometry.axles, AxleSelection::kRear);
  EXPECT_EQ(p.odometry.motion, Motion::kPaper);
  EXPECT_FALSE(p.odometry.shortened_track);
  EXPECT_FALSE(p.odometry.fault_detection);
  EXPECT_EQ(p.calibration.method, CalibrationMethod::kPaper);
  EXPECT_TRUE(p.calibration.allow_partial);
  EXPECT_FALSE(p.publish_tf);
  EXPECT_EQ(p.output, "cal.yaml");
  EXPECT_EQ(p.stamp_source, StampSource::kReceipt);
}

TEST(Values, calibrationFindsWhatIsAskedFor) {
  const Parameters p = load(kMinimalVehicle, {{"calibration/estimate", "[gains, laser_mount]"}}).parameters;
  EXPECT_THAT(p.calibration.estimate, ElementsAre("gains", "laser_mount"));
}

TEST(Numbers, mayBeStringsThatAreWhollyNumeric) {
  // rosparam gives 1e-3 to the server as a string, since YAML 1.1 knows no number without a point.
  EXPECT_EQ(load(kMinimalVehicle, {{"noise/wheel", "1e-3"}}).parameters.noise.wheel.std(), 1e-3);
  EXPECT_EQ(load(kMinimalVehicle, {{"noise/wheel", "\"1e-3\""}}).parameters.noise.wheel.std(), 1e-3);
  EXPECT_EQ(load(kMinimalVehicle, {{"laser/x", "+.5"}}).parameters.laser.x, 0.5);
  EXPECT_EQ(load(kMinimalVehicle, {{"encoders/counter_bits", "16.0"}}).parameters.vehicle.counter_bits, 16);
}

TEST(Track, oneNumberServesBothAxles) {
  const PerAxle<double> track = load(kMinimalVehicle, {{"vehicle/track", "0.9"}}).parameters.vehicle.track;
  EXPECT_EQ(track.front, 0.9);
  EXPECT_EQ(track.rear, 0.9);
  const PerAxle<double> front_set =
      load(kMinimalVehicle, {{"vehicle/track", "0.9"}, {"vehicle/track/front", "0.8"}})
          .parameters.vehicle.track;
  EXPECT_EQ(front_set.front, 0.8);
  EXPECT_EQ(front_set.rear, 0.9);
}

TEST(Frames, O9_aLeadingSlashIsStrippedWithAWarning) {
  const LoadedParameters loaded = load(
      kMinimalVehicle, {{"base_frame", "/base"}, {"odom_frame", "//car/odom"}, {"laser/frame", "/laser"}});
  EXPECT_EQ(loaded.parameters.base_frame, "base");
  EXPECT_EQ(loaded.parameters.odom_frame, "car/odom");
  EXPECT_EQ(loaded.parameters.laser.frame, "laser");
  EXPECT_THAT(loaded.warnings, ElementsAre(HasSubstr("base_frame: '/base' is taken as 'base'"),
                                           HasSubstr("odom_frame"), HasSubstr("laser/frame")));
}

TEST(JointStates, onlyTheJointsInUseMustBeNamed) {
  const Overrides rear_axle{{"input", "joint_states"},
                            {"odometry/axles", "rear"},
                            {"joints/rear_left", "rl"},
                            {"joints/rear_right", "rr"},
                            {"vehicle/rear_steering/coefficients", "[0.0]"}};
  EXPECT_EQ(errorOf(kMinimalVehicle, rear_axle), "");
  Overrides steered = rear_axle;
  steered.push_back({"vehicle/rear_steering/coefficients", "[0.0, -1.0]"});
  EXPECT_THAT(errorOf(kMinimalVehicle, steered), HasSubstr("joints/front_steering"));
  steered.push_back({"vehicle/rear_steering/source", "measured"});
  EXPECT_THAT(errorOf(kMinimalVehicle, steered), HasSubstr("joints/rear_steering"));
}

TEST(Overrides, applyLastAndAreCheckedLikeTheFile) {
  EXPECT_EQ(load(kEveryParameter, {{"max_speed", "5"}, {"max_speed", "6"}}).parameters.limits.max_speed, 6.0);
  EXPECT_THAT(errorOf(kEveryParameter, {{"max_speed", "-5"}}), HasSubstr("max_speed: '-5'"));
  EXPECT_THAT(errorOf(kEveryParameter, {{"max_speed", "[1"}}), HasSubstr("max_speed: not YAML"));
}

TEST(Overrides, unknownPathsAreErrorsAllListed) {
  const std::string message = errorOf(kMinimalVehicle, {{"odometry/axels", "rear"}, {"nois/wheel", "1"}});
  EXPECT_THAT(message, HasSubstr("odometry/axels: 'rear'"));
  EXPECT_THAT(message, HasSubstr("the nearest is odometry/axles"));
  EXPECT_THAT(message, HasSubstr("the nearest is noise/wheel"));
}

TEST(Words, areAllThatAParameterTakes) {
  EXPECT_THAT(parameterWords("odometry/axles"), ElementsAre("both", "front", "rear"));
  EXPECT_THAT(parameterWords("noise/wheel"), IsEmpty());
  EXPECT_THROW(parameterWords("odometry/axels"), ParameterError);
}

TEST(Words, thatOfAParameterIsTheOneItWasGiven) {
  for (const std::string path : {"odometry/axles", "vehicle/axle_geometry"})
    for (const std::string& word : parameterWords(path))
      EXPECT_EQ(parameterWord(load(kMinimalVehicle, {{path, word}}).parameters, path), word);
  EXPECT_EQ(parameterWord(load(kMinimalVehicle).parameters, "odometry/axles"), "both");
  EXPECT_EQ(parameterWord(Parameters(), "noise/wheel"), "");
}

TEST(ParameterTree, mayBeEmptyOrUndefined) {
  EXPECT_THROW(loadParameters(YAML::Node()), ParameterError);
  EXPECT_THROW(loadParameters(YAML::Node(YAML::NodeType::Undefined)), ParameterError);
  EXPECT_THROW(loadParameters(YAML::Load("[1, 2]")), ParameterError);
}

}  // namespace
}  // namespace bs_car_odometry::testing
