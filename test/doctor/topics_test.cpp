// Topics that are missing, and the remappings that the doctor tells.

#include "damaged_drive.hpp"

#include <gmock/gmock.h>

#include <array>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Damage renamed(const std::string& from, const std::string& to) {
  return [=](SimulatedMessage& message) {
    if (message.topic == from) message.topic = to;
    return true;
  };
}

TEST(DoctorOfTopics, tellsTheRemapping) {
  const Damage damage = renamed("laser_pose", "amcl_pose");
  const doctor::Examination examination = Patient(cycab()).examine(damage);
  EXPECT_THAT(errors(examination),
              HasSubstr("ERROR  topic /laser_pose (geometry_msgs/PoseWithCovarianceStamped) is missing: give "
                        "laser_pose:=/amcl_pose\n"));
  EXPECT_EQ(examination.exitStatus(), 3);
}

TEST(DoctorOfTopics, takesTheRemapping) {
  const std::array<const char*, 2> arguments{"bag_doctor", "laser_pose:=amcl_pose"};
  const TopicNames names(2, arguments.data(), {"laser_pose"});
  EXPECT_EQ(troubles(Patient(cycab()).examine(cycab(), renamed("laser_pose", "amcl_pose"), names)), "");
}

TEST(DoctorOfTopics, listsSeveralToChooseFrom) {
  EXPECT_THAT(errors(Patient(cycab()).examine([](SimulatedMessage& message) {
                if (message.topic == "front_steering")
                  message.topic = message.receipt.time_since_epoch().count() % 3 == 0 ? "a" : "b";
                return true;
              })),
              HasSubstr("give one of front_steering:=/a, front_steering:=/b"));
}

TEST(DoctorOfTopics, namesAllThatIsMissing) {
  const Damage damage = [](SimulatedMessage& message) { return message.topic == "ground_truth"; };
  EXPECT_THAT(
      errors(Patient(cycab()).examine(damage)),
      AllOf(HasSubstr("/wheel_ticks (bs_car_odometry/WheelTicks) is missing: record it; the bag holds "
                      "/ground_truth (nav_msgs/Odometry)"),
            HasSubstr("/front_steering"), HasSubstr("/laser_pose")));
}

TEST(DoctorOfTopics, asksForNoSteeringThatDoesNotMatter) {
  EXPECT_EQ(errors(Patient(differential(), "rectangle").examine()), "");
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
