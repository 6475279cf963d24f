#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <map>
#include <vector>

namespace bs_car_odometry::tools {

/// One drive, linearised about the gains in force: y = Phi a + noise, with what the gains lack, a, and the
/// joint covariance of the noise at all places, V = V_0 + sum_k theta_k V_k (docs/model.md, R1).
struct LinearDrive {
  Eigen::VectorXd error;                    ///< y (n): truth less odometry at the places, [m] and [rad]
  Eigen::MatrixXd sensitivity;              ///< Phi (n x p)
  Eigen::MatrixXd known;                    ///< V_0 (n x n)
  std::vector<Eigen::MatrixXd> components;  ///< V_k (n x n), one for each variance that is sought

  /// V. @param variances  at least one for each component; those beyond are not read
  Eigen::MatrixXd covariance(const Eigen::VectorXd& variances) const;
};

/// A drive with what it shares with others.
struct GroupedDrive {
  const LinearDrive* drive;  ///< must outlive the model
  std::size_t wheels;        ///< number of the set of wheels: drives on the same wheels have the same gains
  std::size_t recording;     ///< number of the recording: its drives share one draw of systematic errors
};

/// The gains' errors a before any drive: Gaussian, independent.
struct GainPrior {
  Eigen::VectorXd mean;      ///< (p)
  Eigen::VectorXd variance;  ///< (p), above 0
};

/// What the drives say of a, for one set of wheels.
struct GainEstimate {
  Eigen::VectorXd mean;        ///< (p)
  Eigen::MatrixXd covariance;  ///< (p x p)
};

/// Sufficient statistics of a after the noise, and everything the likelihood needs:
/// -2 log L(a) = log_determinant + square - 2 a^T vector + a^T matrix a.
struct Information {
  explicit Information(Eigen::Index gains);
  void add(const Information& other);

  Eigen::MatrixXd matrix;  ///< Phi^T V^-1 Phi
  Eigen::VectorXd vector;  ///< Phi^T V^-1 y
  double square{0.0};      ///< y^T V^-1 y
  double log_determinant{0.0};
  Eigen::Index rows{0};
};

/// Drives whose errors come from noise along the path, from systematic errors drawn once for each recording
/// and from gains common to a set of wheels, integrated out (restricted likelihood; docs/model.md, R2, R3).
/// Variances are listed theta_1 ... theta_q of the components, then those of the systematic errors.
class VarianceComponents {
 public:
  /// @param priors  one for each set of wheels
  /// @param draws   for each gain the number of its systematic variance, from 0; -1: it does not vary
  VarianceComponents(std::vector<GroupedDrive> drives, std::vector<GainPrior> priors, std::vector<int> draws);

  /// log p(y | variances); minus infinity where a covariance is not positive definite.
  double logLikelihood(const Eigen::VectorXd& variances) const;

  /// One for each set of wheels.
  std::vector<GainEstimate> gains(const Eigen::VectorXd& variances) const;

  /// What the drives of each recording say of its own draw of systematic errors: their mean (p), by the
  /// number of the recording.
  std::map<std::size_t, Eigen::VectorXd> recordingDraws(const Eigen::VectorXd& variances) const;

  /// Variances with which a gain differs between recordings (p).
  Eigen::VectorXd systematicVariances(const Eigen::VectorXd& variances) const;

 private:
  /// One recording, before its draw is integrated over.
  struct RecordingInformation {
    std::size_t recording;
    std::size_t wheels;
    Information information;
  };

  std::vector<RecordingInformation> informationOfRecordings(const Eigen::VectorXd& variances) const;
  std::vector<Information> informationOfWheels(const Eigen::VectorXd& variances) const;

  std::vector<GroupedDrive> drives_;  ///< ordered by recording
  std::vector<GainPrior> priors_;
  std::vector<int> draws_;
  Eigen::Index components_;
};

}  // namespace bs_car_odometry::tools
