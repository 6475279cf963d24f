// Parameter server to YAML; no master is needed to convert a value.

#include "bs_car_odometry/ros/parameter_server.hpp"

#include "bs_car_odometry/parameters/load.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <string>

namespace bs_car_odometry {
namespace {

using XmlRpc::XmlRpcValue;

TEST(ToYaml, scalarsKeepTheirValue) {
  EXPECT_TRUE(toYaml(XmlRpcValue(true)).as<bool>());
  EXPECT_FALSE(toYaml(XmlRpcValue(false)).as<bool>());
  EXPECT_EQ(toYaml(XmlRpcValue(-7)).as<int>(), -7);
  EXPECT_EQ(toYaml(XmlRpcValue("1e-3")).as<std::string>(), "1e-3");
  EXPECT_EQ(toYaml(XmlRpcValue("")).as<std::string>(), "");
  EXPECT_TRUE(toYaml(XmlRpcValue()).IsNull());
}

TEST(ToYaml, doublesKeepEveryDigit) {
  for (const double value : {0.1, 1.0 / 3.0, -1e-300, 1.7976931348623157e308, 5e-324, 12345678.9012345678}) {
    EXPECT_EQ(std::strtod(toYaml(XmlRpcValue(value)).Scalar().c_str(), nullptr), value);
  }
  EXPECT_TRUE(std::isnan(toYaml(XmlRpcValue(std::nan(""))).as<double>()));
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(toYaml(XmlRpcValue(infinity)).as<double>(), infinity);
  EXPECT_EQ(toYaml(XmlRpcValue(-infinity)).as<double>(), -infinity);
}

TEST(ToYaml, structsAndArraysAreNested) {
  XmlRpcValue value;
  value["vehicle"]["track"]["front"] = 1.2;
  value["coefficients"][0] = 0;
  value["coefficients"][1] = -1.0;
  const YAML::Node tree = toYaml(value);
  EXPECT_EQ(tree["vehicle"]["track"]["front"].as<double>(), 1.2);
  ASSERT_TRUE(tree["coefficients"].IsSequence());
  ASSERT_EQ(tree["coefficients"].size(), 2u);
  EXPECT_EQ(tree["coefficients"][1].as<double>(), -1.0);
}

TEST(ToYaml, emptyArraysStayArrays) {
  XmlRpcValue value;
  value.setSize(0);
  EXPECT_TRUE(toYaml(value).IsSequence());
  EXPECT_EQ(toYaml(value).size(), 0u);
}

TEST(ToYaml, binaryAndDateAreText) {
  char bytes[] = {'a', 'b', 'c'};
  EXPECT_EQ(toYaml(XmlRpcValue(bytes, 3)).Scalar(), "YWJj");
  std::tm date{};
  date.tm_year = 126;
  date.tm_mday = 2;
  EXPECT_EQ(toYaml(XmlRpcValue(&date)).Scalar(), "2026-01-02T00:00:00");
}

TEST(ToYaml, parametersOfAServerLoad) {
  XmlRpcValue value;
  value["vehicle"]["wheelbase"] = 2;
  value["vehicle"]["track"]["front"] = 1.1;
  value["vehicle"]["track"]["rear"] = "1.2e0";
  for (const char* wheel : {"front_left", "front_right", "rear_left", "rear_right"})
    value["encoders"]["metres_per_tick"][wheel] = 0.1 + 0.2;
  value["publish_tf"] = false;
  const Parameters p = loadParameters(toYaml(value)).parameters;
  EXPECT_EQ(p.vehicle.wheelbase, 2.0);
  EXPECT_EQ(p.vehicle.track.rear, 1.2);
  EXPECT_EQ(p.vehicle.metres_per_tick[Wheel::kRearRight], 0.1 + 0.2);
  EXPECT_FALSE(p.publish_tf);
}

TEST(ToYaml, distributionsOfAServerLoad) {
  XmlRpcValue value;
  value["vehicle"]["wheelbase"] = 2;
  value["vehicle"]["track"] = 1.1;
  for (const char* wheel : {"front_left", "front_right", "rear_left", "rear_right"})
    value["encoders"]["metres_per_tick"][wheel] = 0.1;
  value["noise"]["wheel"]["distribution"] = "student_t";
  value["noise"]["wheel"]["scale"] = 0.01;
  value["noise"]["wheel"]["degrees_of_freedom"] = 1;
  value["noise"]["wheel"]["truncation"] = "5e-2";
  value["noise"]["steering"]["std"]["distribution"] = "uniform";
  value["noise"]["steering"]["std"]["half_width"] = 0.02;
  const LoadedParameters loaded = loadParameters(toYaml(value));
  EXPECT_TRUE(loaded.warnings.empty());
  const NoiseModel& noise = loaded.parameters.noise;
  EXPECT_EQ(noise.wheel.shape(), Distribution::Shape::kStudentT);
  EXPECT_EQ(noise.wheel.scale(), 0.01);
  EXPECT_EQ(noise.wheel.degreesOfFreedom(), 1.0);
  EXPECT_EQ(noise.wheel.truncation(), 0.05);
  EXPECT_EQ(noise.steering.angle.shape(), Distribution::Shape::kUniform);
  EXPECT_EQ(noise.steering.angle.scale(), 0.02);
}

TEST(ToYaml, P1_parametersOfAServerThatAreNotFiniteAreRefused) {
  XmlRpcValue value;
  value["noise"]["wheel"] = std::nan("");
  try {
    loadParameters(toYaml(value));
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("noise/wheel: '.nan' is not finite"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace bs_car_odometry
