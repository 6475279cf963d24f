#include "schema.hpp"

#include <utility>

namespace bs_car_odometry::schema {
namespace {

constexpr double kPi = 3.14159265358979;

Schema generalSchema(Parameters& p) {
  return {
      text("base_frame", p.base_frame, "the name of a frame"),
      text("odom_frame", p.odom_frame, "the name of a frame"),
      flag("publish_tf", p.publish_tf),
      choice<InputSource>(
          "input", p.input,
          {{{"wheel_ticks", InputSource::kWheelTicks}, {"joint_states", InputSource::kJointStates}}}),
      flag("accept_calibration", p.accept_calibration),
      text("calibration_file", p.calibration_file, "the path of a file, or nothing"),
      flag("require_calibration", p.require_calibration),
      text("output", p.output, "the path of a file"),
  };
}

Schema vehicleSchema(Vehicle& v) {
  using Source = RearSteering::Source;
  return {
      text("vehicle/name", v.name),
      required(number("vehicle/wheelbase", v.wheelbase, above(0, 100, "m"))),
      required(oneForBothAxles(number("vehicle/track/front", v.track.front, above(0, 100, "m")))),
      required(oneForBothAxles(number("vehicle/track/rear", v.track.rear, above(0, 100, "m")))),
      number("vehicle/base_link_x", v.base_link_x, from(-100, 100, "m")),
      oneForBothAxles(number("vehicle/hub_offset/front", v.hub_offset.front, from(-10, 10, "m"))),
      oneForBothAxles(number("vehicle/hub_offset/rear", v.hub_offset.rear, from(-10, 10, "m"))),
      choice<AxleGeometry>("vehicle/axle_geometry", v.axle_geometry,
                           {{{"ackermann", AxleGeometry::kAckermann}, {"pivot", AxleGeometry::kPivot}}}),
      choice<Source>("vehicle/rear_steering/source", v.rear_steering.source,
                     {{{"polynomial", Source::kPolynomial}, {"measured", Source::kMeasured}}}),
      numbers("vehicle/rear_steering/coefficients", v.rear_steering.coefficients, 1, 16, 1e6),
  };
}

Schema encoderSchema(Vehicle& v) {
  // Wider counters cannot wrap on any drive: 0 serves them.
  Schema schema{zeroOrInteger("encoders/counter_bits", v.counter_bits, 8, 32)};
  for (const Wheel wheel : kAllWheels)
    schema.push_back(required(number(std::string("encoders/metres_per_tick/") + name(wheel),
                                     v.metres_per_tick[wheel], from(-10, 10, "m; 0: no encoder"))));
  return schema;
}

Schema jointSchema(JointNames& joints) {
  Schema schema;
  for (const Wheel wheel : kAllWheels)
    schema.push_back(text(std::string("joints/") + name(wheel), joints.wheels[wheel], "the name of a joint"));
  for (const Axle axle : kAllAxles)
    schema.push_back(texts(std::string("joints/") + name(axle) + "_steering", joints.steering[axle], 2,
                           "a list of one joint, or of the left and the right wheel's"));
  return schema;
}

Schema steeringSchema(Vehicle& v) {
  Schema schema;
  for (const Axle axle : kAllAxles) {
    const std::string path = std::string("steering/") + name(axle);
    schema.push_back(nonZeroNumber(path + "/scale", v.steering[axle].scale, from(-1000, 1000)));
    schema.push_back(number(path + "/offset", v.steering[axle].offset, from(-kPi, kPi, "rad")));
  }
  return schema;
}

Schema gainSchema(Vehicle& v) {
  Schema schema;
  for (const Axle axle : kAllAxles) {
    const std::string path = std::string("gains/") + name(axle);
    schema.push_back(number(path + "/k_r", v.gains[axle].k_r, from(0.5, 2)));
    schema.push_back(number(path + "/k_l", v.gains[axle].k_l, from(0.5, 2)));
    schema.push_back(number(path + "/k_b", v.gains[axle].k_b, from(0.5, 2)));
  }
  return schema;
}

Schema odometrySchema(OdometryOptions& o) {
  return {
      choice<AxleSelection>("odometry/axles", o.axles,
                            {{{"both", AxleSelection::kBoth},
                              {"front", AxleSelection::kFront},
                              {"rear", AxleSelection::kRear}}}),
      choice<Motion>("odometry/motion", o.motion, {{{"exact", Motion::kExact}, {"paper", Motion::kPaper}}}),
      flag("odometry/shortened_track", o.shortened_track),
      flag("odometry/fault_detection", o.fault_detection),
      choice<Uncertainty>("odometry/uncertainty", o.uncertainty,
                          {{{"first_order", Uncertainty::kFirstOrder},
                            {"exact_moments", Uncertainty::kExactMoments},
                            {"closed_form", Uncertainty::kClosedForm},
                            {"paper2_simplified", Uncertainty::kPaper2Simplified},
                            {"monte_carlo", Uncertainty::kMonteCarlo}}}),
      choice<SystematicRule>(
          "odometry/systematic_rule", o.systematic_rule,
          {{{"degree_five", SystematicRule::kDegreeFive}, {"sensitivity", SystematicRule::kSensitivity}}}),
      integer("odometry/particles/count", o.particles.count, 100, 1000000),
      integer("odometry/particles/seed", o.particles.seed, 0, 2147483647),
      integer("odometry/particles/threads", o.particles.threads, 1, 64),
      integer("odometry/particles/published", o.particles.published, 0, 100000),
  };
}

Schema noiseSchema(NoiseModel& n) {
  return {
      distribution("noise/wheel", n.wheel, from(0, 10, "m/sqrt(m)")),
      distribution("noise/steering/std", n.steering.angle, from(0, kPi / 2, "rad")),
      number("noise/steering/correlation_length", n.steering.correlation_length, above(0, 1000, "m")),
      distribution("noise/lateral", n.lateral, from(0, 10, "m/sqrt(m)")),
      distribution("noise/rear_law", n.rear_law, from(0, kPi / 2, "rad")),
      distribution("noise/systematic/k_r", n.systematic.k_r, from(0, 1)),
      distribution("noise/systematic/k_l", n.systematic.k_l, from(0, 1)),
      distribution("noise/systematic/k_b", n.systematic.k_b, from(0, 1)),
      distribution("noise/systematic/steering_offset", n.systematic.steering_offset, from(0, kPi / 2, "rad")),
  };
}

Schema calibrationSchema(CalibrationOptions& c) {
  return {
      choice<CalibrationMethod>(
          "calibration/method", c.method,
          {{{"joint", CalibrationMethod::kJoint}, {"paper", CalibrationMethod::kPaper}}}),
      subset("calibration/estimate", c.estimate,
             {"gains", "steering_offset", "steering_scale", "laser_mount", "time_offset"}),
      number("calibration/prior/k_r", c.prior.k_r, above(0, 1)),
      number("calibration/prior/k_l", c.prior.k_l, above(0, 1)),
      number("calibration/prior/k_b", c.prior.k_b, above(0, 1)),
      number("calibration/prior/steering_offset", c.prior.steering_offset, above(0, kPi / 2, "rad")),
      number("calibration/prior/steering_scale", c.prior.steering_scale, above(0, 1)),
      number("calibration/gain_random_walk", c.gain_random_walk, from(0, 1, "1/sqrt(m)")),
      flag("calibration/allow_partial", c.allow_partial),
      number("calibration/straight_limit", c.straight_limit, above(0, 1.3, "rad")),
  };
}

Schema laserSchema(LaserMount& laser) {
  return {
      text("laser/frame", laser.frame, "the name of a frame, or nothing"),
      number("laser/x", laser.x, from(-100, 100, "m")),
      number("laser/y", laser.y, from(-100, 100, "m")),
      number("laser/yaw", laser.yaw, from(-2 * kPi, 2 * kPi, "rad")),
      number("laser/time_offset", laser.time_offset, from(-10, 10, "s")),
  };
}

Schema initialPoseSchema(InitialPose& pose) {
  return {
      number("initial_pose/x", pose.x, from(-1e9, 1e9, "m")),
      number("initial_pose/y", pose.y, from(-1e9, 1e9, "m")),
      number("initial_pose/yaw", pose.yaw, from(-1e6, 1e6, "rad")),
      covariance("initial_pose/covariance", pose.covariance),
  };
}

Schema limitSchema(Parameters& p) {
  InputLimits& limits = p.limits;
  return {
      number("laser_sigma/position", p.laser_sigma.position, above(0, 1000, "m")),
      number("laser_sigma/yaw", p.laser_sigma.yaw, above(0, kPi, "rad")),
      number("max_speed", limits.max_speed, above(0, 1000, "m/s")),
      seconds("max_gap", limits.max_gap, above(0, 3600, "s")),
      seconds("max_future", limits.max_future, from(0, 3600, "s")),
      number("steering_limit", limits.steering_limit, above(0, 1.3, "rad")),
      seconds("max_steering_age", limits.max_steering_age, above(0, 3600, "s")),
      seconds("steering_wait", limits.steering_wait, from(0, 2, "s")),
      choice<StampSource>("stamp_source", p.stamp_source,
                          {{{"header", StampSource::kHeader}, {"receipt", StampSource::kReceipt}}}),
      number("unmeasured_variance", p.unmeasured_variance, from(0, 1e12, "m^2, rad^2")),
      seconds("relative_motion/history", p.relative_motion.history, from(0, 3600, "s; 0: none is kept")),
  };
}

}  // namespace

Schema parameterSchema(Parameters& p) {
  Schema schema;
  for (Schema group : {generalSchema(p), vehicleSchema(p.vehicle), encoderSchema(p.vehicle),
                       jointSchema(p.joints), steeringSchema(p.vehicle), gainSchema(p.vehicle),
                       odometrySchema(p.odometry), noiseSchema(p.noise), calibrationSchema(p.calibration),
                       laserSchema(p.laser), initialPoseSchema(p.initial_pose), limitSchema(p)})
    for (Entry& entry : group) schema.push_back(std::move(entry));
  return schema;
}

}  // namespace bs_car_odometry::schema
