#include "csv_to_bag_options.hpp"

#include <cmath>

namespace bs_car_odometry::tools {
namespace {

namespace po = boost::program_options;

const char* const kUsage =
    "csv_to_bag --wheels W.csv [--steering S.csv] [--pose P.csv] [options] --output OUT.bag [name:=topic "
    "...]\n"
    "\n"
    "Makes a bag with the topics of bs_car_odometry from a recording kept as CSV: wheel_ticks, "
    "front_steering\n"
    "and rear_steering, laser_pose and ground_truth (both from the poses). A recording that begins before "
    "1e6 s\n"
    "is moved by 1.6e9 s. Exit status 3: bad input.";

po::options_description describeOptions() {
  po::options_description options("options");
  auto add = options.add_options();
  add("wheels", po::value<std::string>()->required(), "CSV with the columns t and any of fl, fr, rl, rr");
  add("steering", po::value<std::string>(), "CSV with the columns t, angle or t, front, rear");
  add("pose", po::value<std::string>(), "CSV with the columns t, x, y, yaw [s, m, m, rad]");
  add("wheel-unit", po::value<std::string>()->default_value("ticks"),
      "ticks, tick_increments (since the row before), m/s, rpm or rad/s");
  add("wheel-radius", po::value<double>(), "radius of the wheels [m], for rpm and rad/s");
  add("metres-per-tick", po::value<double>()->default_value(1e-5, "1e-5"),
      "metres a tick of the counters that speeds are integrated into");
  add("steering-unit", po::value<std::string>()->default_value("rad"), "rad or deg");
  add("steering-ratio", po::value<double>()->default_value(1.0, "1"),
      "reading divided by the angle of the axle, such as that of the steering wheel");
  add("output", po::value<std::string>()->required(), "the bag to write");
  return options;
}

std::string textOf(const po::variables_map& values, const std::string& name) {
  return values.count(name) > 0 ? values[name].as<std::string>() : "";
}

double positive(const po::variables_map& values, const std::string& name) {
  const double value = values[name].as<double>();
  if (!std::isfinite(value) || value <= 0.0) throw InputError("--" + name + " must be a number above 0");
  return value;
}

/// Negative where the steering wheel is read to the right.
double steeringRatio(const po::variables_map& values) {
  const double ratio = values["steering-ratio"].as<double>();
  if (!std::isfinite(ratio) || ratio == 0.0)
    throw InputError("--steering-ratio must be a number other than 0");
  return ratio;
}

double radiansPerUnit(const std::string& unit) {
  if (unit == "rad") return 1.0;
  if (unit == "deg") return 3.14159265358979323846 / 180.0;
  throw InputError("--steering-unit '" + unit + "' is not known; known: rad, deg");
}

CsvSource sourceOf(const po::variables_map& values) {
  CsvSource source;
  source.wheels_file = textOf(values, "wheels");
  source.steering_file = textOf(values, "steering");
  source.pose_file = textOf(values, "pose");
  source.wheel_unit = wheelUnit(textOf(values, "wheel-unit"));
  const bool radius_given = values.count("wheel-radius") > 0;
  if (radius_given) source.wheel_radius = positive(values, "wheel-radius");
  if (needsRadius(source.wheel_unit) && !radius_given)
    throw InputError("--wheel-unit " + textOf(values, "wheel-unit") + " needs --wheel-radius");
  source.metres_per_tick = positive(values, "metres-per-tick");
  source.radians_per_unit = radiansPerUnit(textOf(values, "steering-unit"));
  source.steering_ratio = steeringRatio(values);
  return source;
}

}  // namespace

CsvToBagOptions csvToBagOptions(int argc, const char* const* argv) {
  const po::variables_map values = parseCommandLine(argc, argv, kUsage, describeOptions());
  const TopicNames topics(argc, argv,
                          {"wheel_ticks", "front_steering", "rear_steering", "laser_pose", "ground_truth"});
  return {sourceOf(values), topics, textOf(values, "output")};
}

}  // namespace bs_car_odometry::tools
