// Unknown names: a warning that names the nearest known one.

#include "vehicle_file.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The known name that the warning about `text` offers.
std::string nearestTo(const std::string& text) {
  const std::vector<std::string> warnings = load(std::string(kMinimalVehicle) + text).warnings;
  if (warnings.size() != 1) return "(" + std::to_string(warnings.size()) + " warnings)";
  const std::string marker = "the nearest known one is ";
  const std::size_t at = warnings.front().find(marker);
  return at == std::string::npos ? warnings.front() : warnings.front().substr(at + marker.size());
}

TEST(UnknownNames, P4_misspellingsFindTheNearestKnownName) {
  EXPECT_EQ(nearestTo("base_frme: a"), "base_frame");
  EXPECT_EQ(nearestTo("Publish_TF: true"), "publish_tf");
  EXPECT_EQ(nearestTo("max_gpa: 1"), "max_gap");
  EXPECT_EQ(nearestTo("noise: {whel: 1}"), "noise/wheel");
  EXPECT_EQ(nearestTo("noise: {steering: {sdt: 1}}"), "noise/steering/std");
  EXPECT_EQ(nearestTo("odometry: {axle: rear}"), "odometry/axles");
  EXPECT_EQ(nearestTo("gains: {rear: {kb: 1}}"), "gains/rear/k_b");
  EXPECT_EQ(nearestTo("gains: {raer: {k_b: 1}}"), "gains/rear");
  EXPECT_EQ(nearestTo("nose: {wheel: 1}"), "noise");
}

TEST(UnknownNames, aNameInTheWrongGroupIsFound) {
  EXPECT_EQ(nearestTo("wheelbase: 1.2"), "vehicle/wheelbase");
  EXPECT_EQ(nearestTo("counter_bits: 16"), "encoders/counter_bits");
  EXPECT_EQ(nearestTo("odometry: {max_speed: 3}"), "max_speed");
}

TEST(UnknownNames, P4_ofAnyLengthAreComparedByTheirBeginning) {
  const std::string beginning(64, 'x');
  EXPECT_EQ(nearestTo(beginning + "max_gap: 1"), nearestTo(beginning + ": 1"));
  EXPECT_EQ(nearestTo("max_gap" + std::string(1000, 'x') + ": 1"), nearestTo("max_gap" + beginning + ": 1"));
}

TEST(UnknownNames, areAllNamedAndDoNotStopTheStart) {
  EXPECT_THAT(load(std::string(kMinimalVehicle) + "max_gpa: 1\noutptu: a\n").warnings,
              ElementsAre(HasSubstr("max_gpa: unknown parameter"), HasSubstr("outptu: unknown parameter")));
}

TEST(UnknownNames, thoseOfRosItselfDoNotWarn) {
  EXPECT_THAT(load(std::string(kMinimalVehicle) + "diagnostic_period: 1.0\nnum_worker_threads: 2\n").warnings,
              IsEmpty());
}

}  // namespace
}  // namespace bs_car_odometry::testing
