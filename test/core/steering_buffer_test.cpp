#include "bs_car_odometry/core/steering_buffer.hpp"

#include <gtest/gtest.h>

namespace bs_car_odometry {
namespace {

using Inserted = SteeringBuffer::Inserted;

Time at(int milliseconds) { return Time(std::chrono::milliseconds(milliseconds)); }

SteeringBuffer filled(const std::initializer_list<int>& milliseconds) {
  SteeringBuffer buffer;
  for (const int stamp : milliseconds) buffer.insert(at(stamp), 0.001 * stamp);
  return buffer;
}

TEST(SteeringBuffer, IsEmptyAtFirst) {
  const SteeringBuffer buffer;
  EXPECT_TRUE(buffer.empty());
  EXPECT_FALSE(buffer.newest());
  EXPECT_FALSE(buffer.newestUntil(at(10)));
}

TEST(SteeringBuffer, InterpolatesBetweenTheReadingsAround) {
  SteeringBuffer buffer;
  buffer.insert(at(0), 0.1);
  buffer.insert(at(10), 0.2);
  buffer.insert(at(20), 0.6);
  EXPECT_DOUBLE_EQ(buffer.angleAt(at(5)), 0.15);
  EXPECT_DOUBLE_EQ(buffer.angleAt(at(10)), 0.2);
  EXPECT_DOUBLE_EQ(buffer.angleAt(at(15)), 0.4);
}

TEST(SteeringBuffer, FindsReadingsOfLongAgo) {
  SteeringBuffer buffer;
  for (int i = 0; i < 100; ++i) buffer.insert(at(10 * i), 0.01 * i);
  for (int i = 0; i < 100; ++i) {
    EXPECT_DOUBLE_EQ(buffer.angleAt(at(10 * i)), 0.01 * i);
    EXPECT_EQ(buffer.newestUntil(at(10 * i + 5)), at(10 * i));
  }
  EXPECT_EQ(buffer.insert(at(20), 0.0), Inserted::kRepeated);
}

TEST(SteeringBuffer, HoldsBeforeTheFirstAndAfterTheLast) {
  const SteeringBuffer buffer = filled({10, 20});
  EXPECT_EQ(buffer.angleAt(at(0)), 0.01);
  EXPECT_EQ(buffer.angleAt(at(30)), 0.02);
}

TEST(SteeringBuffer, TakesReadingsInAnyOrder) {
  const SteeringBuffer in_order = filled({0, 10, 20, 30});
  const SteeringBuffer shuffled = filled({20, 0, 30, 10});
  for (int stamp = -5; stamp < 40; ++stamp)
    EXPECT_EQ(shuffled.angleAt(at(stamp)), in_order.angleAt(at(stamp)));
  EXPECT_EQ(shuffled.newest(), at(30));
}

TEST(SteeringBuffer, ReportsARepeatedStampAndKeepsTheFirstAngle) {
  SteeringBuffer buffer = filled({0, 10});
  EXPECT_EQ(buffer.insert(at(10), 5.0), Inserted::kRepeated);
  EXPECT_EQ(buffer.insert(at(0), 5.0), Inserted::kRepeated);
  EXPECT_EQ(buffer.angleAt(at(10)), 0.01);
  EXPECT_EQ(buffer.angleAt(at(0)), 0.0);
}

TEST(SteeringBuffer, NamesTheNewestNotAfterAStamp) {
  const SteeringBuffer buffer = filled({10, 20});
  EXPECT_FALSE(buffer.newestUntil(at(9)));
  EXPECT_EQ(buffer.newestUntil(at(10)), at(10));
  EXPECT_EQ(buffer.newestUntil(at(19)), at(10));
  EXPECT_EQ(buffer.newestUntil(at(99)), at(20));
}

TEST(SteeringBuffer, N9_KeepsTheNewestOfAFullBuffer) {
  SteeringBuffer buffer(4);
  for (int stamp = 0; stamp < 100; ++stamp) EXPECT_EQ(buffer.insert(at(stamp), stamp), Inserted::kYes);
  for (int stamp = 96; stamp < 100; ++stamp) EXPECT_EQ(buffer.angleAt(at(stamp)), stamp);
  EXPECT_GT(buffer.angleAt(at(0)), 90.0);  // long forgotten: held
}

TEST(SteeringBuffer, RefusesWhatIsOlderThanAFullBuffer) {
  SteeringBuffer buffer(4);
  for (int stamp = 10; stamp < 14; ++stamp) buffer.insert(at(stamp), stamp);
  EXPECT_EQ(buffer.insert(at(9), 9.0), Inserted::kTooOld);
  EXPECT_EQ(buffer.angleAt(at(9)), 10.0);
}

TEST(SteeringBuffer, ClearForgetsAll) {
  SteeringBuffer buffer = filled({10, 20});
  buffer.clear();
  EXPECT_TRUE(buffer.empty());
  EXPECT_EQ(buffer.insert(at(5), 0.5), Inserted::kYes);
  EXPECT_EQ(buffer.angleAt(at(50)), 0.5);
}

}  // namespace
}  // namespace bs_car_odometry
