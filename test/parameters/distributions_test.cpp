// Distributions in place of the standard deviations of `noise`.

#include "vehicle_file.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace bs_car_odometry::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Shape = Distribution::Shape;

Distribution wheel(const std::string& value) {
  return load(kMinimalVehicle, {{"noise/wheel", value}}).parameters.noise.wheel;
}

TEST(Distributions, ofEveryShapeAreRead) {
  const Distribution gaussian = wheel("{distribution: gaussian, std: 0.02}");
  EXPECT_EQ(gaussian.shape(), Shape::kGaussian);
  EXPECT_EQ(gaussian.std(), 0.02);
  EXPECT_EQ(gaussian.truncation(), Distribution::kNotTruncated);
  const Distribution uniform = wheel("{distribution: uniform, half_width: 0.02}");
  EXPECT_EQ(uniform.shape(), Shape::kUniform);
  EXPECT_EQ(uniform.scale(), 0.02);
  const Distribution triangular = wheel("{half_width: \"2e-2\", distribution: triangular}");
  EXPECT_EQ(triangular.shape(), Shape::kTriangular);
  EXPECT_EQ(triangular.scale(), 0.02);
  const Distribution student = wheel("{distribution: student_t, scale: 0.02, degrees_of_freedom: 5}");
  EXPECT_EQ(student.shape(), Shape::kStudentT);
  EXPECT_EQ(student.scale(), 0.02);
  EXPECT_EQ(student.degreesOfFreedom(), 5.0);
  EXPECT_EQ(student.truncation(), Distribution::kNotTruncated);
}

TEST(Distributions, mayBeTruncated) {
  const Distribution gaussian = wheel("{distribution: gaussian, std: 0.02, truncation: 0.03}");
  EXPECT_EQ(gaussian.scale(), 0.02);
  EXPECT_EQ(gaussian.truncation(), 0.03);
  EXPECT_EQ(gaussian.std(), Distribution::gaussian(0.02, 0.03).std());
  EXPECT_LT(gaussian.std(), 0.02);
  const Distribution student =
      wheel("{distribution: student_t, scale: 0.02, degrees_of_freedom: 1, truncation: 0.2}");
  EXPECT_EQ(student.degreesOfFreedom(), 1.0);
  EXPECT_EQ(student.truncation(), 0.2);
  EXPECT_EQ(wheel("{distribution: gaussian, std: 0.1, truncation: 0.05}").truncation(), 0.05) << "the least";
  EXPECT_EQ(wheel("{distribution: gaussian, std: 0, truncation: 1}").std(), 0.0);
  // The smallest number there is: its half is 0.
  EXPECT_EQ(wheel("{distribution: gaussian, std: 1e-320, truncation: 1e-320}").scale(), 1e-320);
}

const char* const kDistributionsEverywhere = R"(
noise:
  wheel: {distribution: uniform, half_width: 0.01}
  steering:
    std: {distribution: triangular, half_width: 0.02}
    correlation_length: 0.3
  lateral: {distribution: student_t, scale: 0.001, degrees_of_freedom: 5}
  rear_law: {distribution: gaussian, std: 0.002, truncation: 0.004}
  systematic:
    k_r: {distribution: uniform, half_width: 0.03}
    k_l: {distribution: uniform, half_width: 0.04}
    k_b: {distribution: uniform, half_width: 0.05}
    steering_offset: {distribution: uniform, half_width: 0.06}
)";

// Their keys are no parameters, yet they are known.
TEST(Distributions, mayStandInEveryEntryAndWarnOfNothing) {
  const LoadedParameters loaded = load(std::string(kMinimalVehicle) + kDistributionsEverywhere);
  EXPECT_THAT(loaded.warnings, IsEmpty());
  const NoiseModel& noise = loaded.parameters.noise;
  EXPECT_EQ(noise.wheel.scale(), 0.01);
  EXPECT_EQ(noise.steering.angle.scale(), 0.02);
  EXPECT_EQ(noise.steering.angle.shape(), Shape::kTriangular);
  EXPECT_EQ(noise.steering.correlation_length, 0.3);
  EXPECT_EQ(noise.lateral.shape(), Shape::kStudentT);
  EXPECT_EQ(noise.rear_law.truncation(), 0.004);
  EXPECT_EQ(noise.systematic.k_r.scale(), 0.03);
  EXPECT_EQ(noise.systematic.k_l.scale(), 0.04);
  EXPECT_EQ(noise.systematic.k_b.scale(), 0.05);
  EXPECT_EQ(noise.systematic.steering_offset.scale(), 0.06);
  EXPECT_EQ(noise.systematic.steering_offset.shape(), Shape::kUniform);
}

TEST(Distributions, aSettingReplacesThemWhole) {
  const std::string file = std::string(kMinimalVehicle) + kDistributionsEverywhere;
  const NoiseModel noise =
      load(file, {{"noise/wheel", "0.005"}, {"noise/systematic/k_r", "{distribution: gaussian, std: 0.02}"}})
          .parameters.noise;
  EXPECT_EQ(noise.wheel.shape(), Shape::kGaussian);
  EXPECT_EQ(noise.wheel.std(), 0.005);
  EXPECT_EQ(noise.systematic.k_r.shape(), Shape::kGaussian);
  EXPECT_EQ(noise.systematic.k_r.std(), 0.02);
  EXPECT_THAT(errorOf(file, {{"noise/wheel/half_width", "0.1"}}), HasSubstr("no such parameter is known"));
}

TEST(Distributions, thatAreWrongAreAllListedOnceEach) {
  const std::string message =
      errorOf(kMinimalVehicle, {{"noise/wheel", "{distribution: unifrm, halfwidth: -1}"},
                                {"noise/lateral", "{distribution: uniform}"}});
  EXPECT_EQ(
      message,
      "noise/wheel/distribution: 'unifrm' is not known; allowed: gaussian, uniform, triangular or student_t\n"
      "noise/lateral/half_width: is missing; allowed: a number from 0 to 10 [m/sqrt(m)]");
}

}  // namespace
}  // namespace bs_car_odometry::testing
