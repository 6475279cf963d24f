// Trajectories as text: every digit, on both sides of zero and beyond the range of whole nanometres.
#include "../../src/tools/tum_writer.hpp"

#include "temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

namespace bs_car_odometry::tools::testing {
namespace {

std::string written(std::int64_t nanoseconds, const Pose2& pose) {
  const TemporaryFolder folder;
  OdometryUpdate update{};
  update.stamp = timeFromNanoseconds(nanoseconds);
  update.estimate.pose = pose;
  TumWriter writer(folder.file("a.tum"));
  writer.write(update);
  writer.close();
  std::ifstream file(folder.file("a.tum"));
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(TumWriter, writesNineDecimals) {
  EXPECT_EQ(written(1600000000000000007, {12.25, -0.000000125, 0.0}),
            "1600000000.000000007 12.250000000 -0.000000125 0 0 0 0.000000000 1.000000000\n");
}

TEST(TumWriter, carriesWhatItRounds) {
  EXPECT_EQ(written(999999999, {0.9999999996, -1.9999999996, M_PI}),
            "0.999999999 1.000000000 -2.000000000 0 0 0 1.000000000 0.000000000\n");
}

TEST(TumWriter, hasNoNegativeZero) {
  EXPECT_EQ(written(1000000000, {-1e-10, -0.0, 0.0}),
            "1.000000000 0.000000000 0.000000000 0 0 0 0.000000000 1.000000000\n");
}

TEST(TumWriter, writesWhatNanometresCannotHold) {
  EXPECT_EQ(written(1000000000, {8e9, -1e10, 0.0}),
            "1.000000000 8000000000.000000000 -10000000000 0 0 0 0.000000000 1.000000000\n");
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
