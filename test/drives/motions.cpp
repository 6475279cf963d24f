#include "motions.hpp"

#include "bs_car_odometry/laboratory/parallel.hpp"
#include "drive.hpp"

namespace bs_car_odometry::drives {

std::vector<laboratory::Consistency> studyMotions(const laboratory::StudySettings& settings,
                                                  const Interval& interval) {
  std::vector<std::vector<laboratory::Judgement>> judgements(settings.drives);
  laboratory::runInParallel(settings.drives, settings.threads, [&](std::size_t i) {
    DriveSettings drive_settings = settings.drive;
    drive_settings.seed += i;
    const std::vector<Sample> drive = record(settings.odometries.front().vehicle, drive_settings);
    const simulation::Pose truth = trueMotion(drive, interval.from, interval.to);
    for (const OdometryConfiguration& odometry : settings.odometries) {
      const MotionEstimate motion =
          motionBetween(odometry, drive, interval.from, interval.to, interval.every);
      const OdometryEstimate estimate{motion.motion, motion.covariance, Eigen::Vector3d::Zero(),
                                      Eigen::Matrix3d::Zero()};
      judgements[i].push_back(laboratory::judge(estimate, truth));
    }
  });
  std::vector<laboratory::Consistency> results(settings.odometries.size());
  for (const auto& drive : judgements)
    for (std::size_t k = 0; k < results.size(); ++k) results[k].add(drive[k]);
  return results;
}

}  // namespace bs_car_odometry::drives
