// What a calibration asks for when a drive was not enough, and how it recognises a wrong vehicle file.

#include "bs_car_odometry/calibration/advice.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::calibration {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class WhatToDrive : public ::testing::Test {
 protected:
  std::string missing(std::size_t parameter, double deviation) {
    ParameterMask mask{};
    mask[parameter] = true;
    const auto k = static_cast<Eigen::Index>(parameter);
    estimate_.covariance(k, k) = deviation * deviation;
    return whatToDrive(mask, estimate_, prior_, driven_);
  }

  FilterEstimate estimate_;
  ParameterVector prior_{ParameterVector::Constant(0.05)};
  Excitation driven_{20.0, 15.0, 1.0, 0.5};
};

TEST_F(WhatToDrive, nothingIsAskedForWhenNothingIsMissing) {
  EXPECT_EQ(whatToDrive({}, estimate_, prior_, driven_), "");
}

/// 20 m that have taken the variance to a half give information 1/prior^2; three times that is needed.
TEST_F(WhatToDrive, wheelGainsNeedDistanceAtThePaceSoFar) {
  EXPECT_EQ(missing(systematic::kRearRight, 0.05 / std::sqrt(2.0)), "rear/k_r: drive 40 m more");
}

/// 1.5 rad of turns so far, 86 degrees; three times as much is needed, and the right had less.
TEST_F(WhatToDrive, tracksNeedTurnsToTheSideThatHadFewer) {
  EXPECT_EQ(missing(systematic::kRearTrack, 0.05 / std::sqrt(2.0)),
            "rear/k_b: turn 180 degrees more to the right");
}

TEST_F(WhatToDrive, C5_aDriveThatHasShownNothingIsNoMeasure) {
  EXPECT_EQ(missing(systematic::kRearTrack, 0.0499), "rear/k_b: turn 180 degrees more to the right");
  driven_ = {};
  EXPECT_EQ(missing(systematic::kRearLeft, 0.05), "rear/k_l: drive 20 m more");
}

TEST(ImplausibleGains, C7_namesTheGainAndWhatToCheck) {
  ParameterVector values = ParameterVector::Ones();
  ParameterMask estimated{};
  estimated[systematic::kRearRight] = estimated[systematic::kRearTrack] = true;
  EXPECT_EQ(implausibleGains(values, estimated), "");
  values[systematic::kFrontRight] = 2.0;
  EXPECT_EQ(implausibleGains(values, estimated), "") << "it was not estimated";
  values[systematic::kRearTrack] = 0.79;
  EXPECT_THAT(implausibleGains(values, estimated), HasSubstr("rear/k_b = 0.79: outside"));
  EXPECT_THAT(implausibleGains(values, estimated), HasSubstr("vehicle/track"));
  values[systematic::kRearTrack] = 1.0;
  values[systematic::kRearRight] = 0.5;
  EXPECT_THAT(implausibleGains(values, estimated), HasSubstr("radius"));
  EXPECT_THAT(implausibleGains(values, estimated), HasSubstr("ticks per turn"));
  EXPECT_THAT(implausibleGains(values, estimated), Not(HasSubstr("k_b")));
}

}  // namespace
}  // namespace bs_car_odometry::calibration
