#pragma once

#include "bs_car_odometry/laboratory/drive.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace bs_car_odometry::laboratory {

/// One odometry at one place of one drive, against the truth.
struct Judgement {
  double distance{0.0};      ///< [m] truly driven since the start
  Eigen::Vector3d error;     ///< estimate less truth, (x, y, yaw) in odom [m, m, rad]
  Eigen::Vector3d variance;  ///< published, of the same
  double nees{0.0};          ///< of the pose, (N1) of docs/model.md
  double plain_nees{0.0};    ///< of the pose in (x, y, yaw)
  double twist_nees{0.0};    ///< mean over the moving steps since the place before
  std::size_t twists{0};     ///< how many those are; none: no twist_nees

  /// Shares of the poses that the method itself believes to lie within 1, 2 and 3 sigma of the published one,
  /// by (N1) and in (x, y, yaw): those of a Gaussian, or of its particles.
  std::array<double, 3> expected_region{};
  std::array<double, 3> expected_plain_region{};
};

/// The pose of one estimate against the truth; without distance and twists.
Judgement judge(const OdometryEstimate& estimate, const simulation::Pose& truth);

/// How many drives have the truth within 1, 2 and 3 sigma.
using SigmaCounts = std::array<std::size_t, 3>;

/// Many drives' judgements at one place, as sums: adding and merging in the same order gives the same bits.
class Consistency {
 public:
  void add(const Judgement& judgement);
  void merge(const Consistency& other);

  std::size_t drives() const { return drives_; }
  double distance() const { return distance_ / count(); }  ///< mean [m]
  Eigen::Vector3d meanError() const { return error_ / count(); }
  Eigen::Matrix3d errorCovariance() const;  ///< of the errors about their mean
  Eigen::Vector3d sigma() const {
    return (variance_ / count()).cwiseSqrt();
  }  ///< published, root mean square

  double meanNees() const { return nees_ / count(); }
  double meanPlainNees() const { return plain_nees_ / count(); }

  /// Mean over the drives of a drive's own mean, since the twists of one drive share its gains; NaN without
  /// any.
  double meanTwistNees() const { return twist_nees_ / static_cast<double>(twist_drives_); }
  double twistNeesStandardError() const;

  /// Shares of the drives whose truth is within 1, 2 and 3 sigma.
  std::array<double, 3> componentCoverage(Eigen::Index component) const;   ///< 0: x, 1: y, 2: yaw
  std::array<double, 3> regionCoverage() const { return share(region_); }  ///< by (N1)
  std::array<double, 3> plainRegionCoverage() const { return share(plain_region_); }
  /// What the method believes these shares to be, mean over the drives.
  std::array<double, 3> expectedRegionCoverage() const { return mean(expected_region_); }
  std::array<double, 3> expectedPlainRegionCoverage() const { return mean(expected_plain_region_); }

 private:
  double count() const { return static_cast<double>(drives_); }
  std::array<double, 3> share(const SigmaCounts& inside) const;
  std::array<double, 3> mean(std::array<double, 3> sums) const;

  std::size_t drives_{0};
  std::size_t twist_drives_{0};
  double distance_{0.0};
  Eigen::Vector3d error_{Eigen::Vector3d::Zero()};
  Eigen::Matrix3d error_square_{Eigen::Matrix3d::Zero()};
  Eigen::Vector3d variance_{Eigen::Vector3d::Zero()};
  double nees_{0.0};
  double plain_nees_{0.0};
  double twist_nees_{0.0};
  double twist_nees_square_{0.0};
  std::array<SigmaCounts, 3> components_{};
  SigmaCounts region_{};
  SigmaCounts plain_region_{};
  std::array<double, 3> expected_region_{};
  std::array<double, 3> expected_plain_region_{};
};

/// Many noisy drives of one scenario and vehicle; every odometry reads the same ones.
struct StudySettings {
  DriveSettings drive;  ///< its seed is the first one; each drive has the next
  std::size_t drives{0};
  std::vector<OdometryConfiguration> odometries;     ///< the vehicle of the first one drives
  std::size_t places{1};                             ///< judged, at equal distances up to the end
  unsigned threads{0};                               ///< 0: one for each processor
  std::function<void(std::size_t drives)> progress;  ///< may be empty
};

/// What the drives say of one odometry, place by place; the last place is the end.
using ConsistencyOverDistance = std::vector<Consistency>;

/// Drives and judges; the result is the same, bit for bit, for any number of threads.
/// @return one for each odometry
/// @throws simulation::ScenarioError
std::vector<ConsistencyOverDistance> studyConsistency(const StudySettings& settings);

}  // namespace bs_car_odometry::laboratory
