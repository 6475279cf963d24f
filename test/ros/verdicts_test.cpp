// What is said of a message that was turned down.

#include "bs_car_odometry/ros/verdicts.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string refused(double angle) {
  InputCounts counts;
  counts.refused_angle = angle;
  return explain(Verdict::kSteeringLimit, counts);
}

TEST(Verdicts, T1_the_remedy_of_stamp_zero_is_named) {
  EXPECT_EQ(explain(Verdict::kStampZero, InputCounts()),
            "its stamp is zero: stamp messages at the source, or set 'stamp_source: receipt'");
  EXPECT_TRUE(isError(Verdict::kStampZero));
}

TEST(Verdicts, S3_degrees_are_hinted_at_where_they_fit) {
  for (const double angle : {1.31, -1.31, 5.0, -20.0, 74.0})
    EXPECT_THAT(refused(angle), HasSubstr("if it were in degrees: set steering/front/scale")) << angle;
  // Below, a car whose limit is smaller may be meant; beyond, degrees are as impossible.
  for (const double angle : {0.7, -1.3, 75.0, 1e308})
    EXPECT_THAT(refused(angle), Not(HasSubstr("degrees"))) << angle;
  EXPECT_THAT(refused(20.0), HasSubstr("0.349 rad"));
}

TEST(Verdicts, everyOneHasASentence) {
  for (int i = 1; i < static_cast<int>(Verdict::kCount); ++i)
    EXPECT_STRNE(explain(static_cast<Verdict>(i)), "") << i;
}

}  // namespace
}  // namespace bs_car_odometry
