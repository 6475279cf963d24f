#include "bs_car_odometry/calibration/leave_one_out.hpp"

#include "bs_car_odometry/calibration/planar.hpp"
#include "chain.hpp"

namespace bs_car_odometry::calibration {

namespace {

/// Dead reckoning from the first laser pose of a part of a drive to its last one.
class Part {
 public:
  void move(const Link& link) {
    odometry_ = odometry_ * link.motion;
    distance_ += link.distance;
  }

  /// @param laser  base_link as the laser has it
  void take(const Pose2& laser) {
    if (!begun_) {
      odometry_ = laser;
      distance_ = 0.0;
      begun_ = true;
    }
    end_ = {distance_, (odometry_.position() - laser.position()).norm()};
  }

  const Drift& end() const { return end_; }

 private:
  bool begun_{false};
  Pose2 odometry_;
  double distance_{0.0};
  Drift end_;
};

std::vector<bool> trusted(std::size_t lasers, const std::vector<LaserResidual>& residuals) {
  std::vector<bool> trusted(lasers, false);
  for (const LaserResidual& residual : residuals) trusted[residual.laser] = residual.square <= kRejectLimit;
  return trusted;
}

Drift& operator+=(Drift& sum, const Drift& part) {
  sum.distance += part.distance;
  sum.error += part.error;
  return sum;
}

}  // namespace

Drift endDrift(const CalibrationDrive& drive, const Parameters& parameters, const ParameterVector& values,
               const std::vector<LaserResidual>& residuals) {
  const std::vector<bool> use = trusted(drive.lasers().size(), residuals);
  const std::vector<Pose2> any_poses(drive.lasers().size());
  const Pose2 from_laser = inverse(mountOf(values));
  Drift drift;
  Part part;
  for (const Node& node : makeChain(drive, parameters, values, any_poses, {}).nodes) {
    if (node.linked) {
      part.move(node.link);
    } else {
      drift += part.end();
      part = Part();
    }
    if (use[node.laser]) part.take(drive.lasers()[node.laser].laser.pose * from_laser);
  }
  drift += part.end();
  return drift;
}

std::vector<LeftOutDrive> leaveOneOut(const Drives& drives, const Parameters& parameters,
                                      const Refinement& all, const RefinementOptions& options) {
  std::vector<LeftOutDrive> left_out;
  if (drives.size() < 2) return left_out;
  RefinementOptions seeded = options;
  seeded.seed = all.values;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    Drives others = drives;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    LeftOutDrive drive;
    drive.refined = refine(others, parameters, seeded);
    drive.refined.residuals.clear();
    const auto drift = [&](const ParameterVector& values) {
      return endDrift(*drives[i], parameters, values, all.residuals[i]);
    };
    drive.nominal = drift(valuesOf(parameters));
    drive.calibrated = drift(drive.refined.values);
    drive.all = drift(all.values);
    left_out.push_back(std::move(drive));
  }
  return left_out;
}

}  // namespace bs_car_odometry::calibration
