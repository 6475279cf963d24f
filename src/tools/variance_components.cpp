#include "variance_components.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace bs_car_odometry::tools {

namespace {

double logDeterminant(const Eigen::LLT<Eigen::MatrixXd>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

/// Of one drive; an infinite log_determinant says that its covariance is none.
Information informationOf(const LinearDrive& drive, const Eigen::VectorXd& variances) {
  Information information(drive.sensitivity.cols());
  const Eigen::LLT<Eigen::MatrixXd> factor(drive.covariance(variances));
  if (factor.info() != Eigen::Success) {
    information.log_determinant = std::numeric_limits<double>::infinity();
    return information;
  }
  const Eigen::MatrixXd X = factor.matrixL().solve(drive.sensitivity);
  const Eigen::VectorXd y = factor.matrixL().solve(drive.error);
  information.matrix = X.transpose() * X;
  information.vector = X.transpose() * y;
  information.square = y.squaredNorm();
  information.log_determinant = logDeterminant(factor);
  information.rows = drive.error.size();
  return information;
}

/// Integrates over one draw of errors with these variances, 0 among them (R2).
void integrateOver(const Eigen::VectorXd& variances, Information& information) {
  const Eigen::DiagonalMatrix<double, Eigen::Dynamic> root(variances.cwiseSqrt());
  const Eigen::Index p = variances.size();
  const Eigen::LLT<Eigen::MatrixXd> factor(Eigen::MatrixXd::Identity(p, p) +
                                           root * information.matrix * root);
  const Eigen::MatrixXd A = factor.matrixL().solve(root * information.matrix);
  const Eigen::VectorXd b = factor.matrixL().solve(root * information.vector);
  information.matrix -= A.transpose() * A;
  information.vector -= A.transpose() * b;
  information.square -= b.squaredNorm();
  information.log_determinant += logDeterminant(factor);
}

void add(const GainPrior& prior, Information& information) {
  const Eigen::VectorXd weight = prior.variance.cwiseInverse();
  information.matrix += weight.asDiagonal();
  information.vector += weight.cwiseProduct(prior.mean);
  information.square += weight.dot(prior.mean.cwiseAbs2());
  information.log_determinant += prior.variance.array().log().sum();
}

}  // namespace

Eigen::MatrixXd LinearDrive::covariance(const Eigen::VectorXd& variances) const {
  Eigen::MatrixXd V = known;
  for (std::size_t k = 0; k < components.size(); ++k)
    V += variances[static_cast<Eigen::Index>(k)] * components[k];
  return V;
}

Information::Information(Eigen::Index gains)
    : matrix(Eigen::MatrixXd::Zero(gains, gains)), vector(Eigen::VectorXd::Zero(gains)) {}

void Information::add(const Information& other) {
  matrix += other.matrix;
  vector += other.vector;
  square += other.square;
  log_determinant += other.log_determinant;
  rows += other.rows;
}

VarianceComponents::VarianceComponents(std::vector<GroupedDrive> drives, std::vector<GainPrior> priors,
                                       std::vector<int> draws)
    : drives_(std::move(drives)),
      priors_(std::move(priors)),
      draws_(std::move(draws)),
      components_(drives_.empty() ? 0 : static_cast<Eigen::Index>(drives_.front().drive->components.size())) {
  std::stable_sort(drives_.begin(), drives_.end(),
                   [](const GroupedDrive& a, const GroupedDrive& b) { return a.recording < b.recording; });
}

Eigen::VectorXd VarianceComponents::systematicVariances(const Eigen::VectorXd& variances) const {
  Eigen::VectorXd of_gains = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(draws_.size()));
  for (std::size_t j = 0; j < draws_.size(); ++j)
    if (draws_[j] >= 0) of_gains[static_cast<Eigen::Index>(j)] = variances[components_ + draws_[j]];
  return of_gains;
}

std::vector<VarianceComponents::RecordingInformation> VarianceComponents::informationOfRecordings(
    const Eigen::VectorXd& variances) const {
  std::vector<RecordingInformation> recordings;
  for (const GroupedDrive& drive : drives_) {
    if (recordings.empty() || recordings.back().recording != drive.recording)
      recordings.push_back(
          {drive.recording, drive.wheels, Information(static_cast<Eigen::Index>(draws_.size()))});
    recordings.back().information.add(informationOf(*drive.drive, variances));
  }
  return recordings;
}

std::vector<Information> VarianceComponents::informationOfWheels(const Eigen::VectorXd& variances) const {
  const Eigen::VectorXd systematic = systematicVariances(variances);
  std::vector<Information> wheels(priors_.size(), Information(systematic.size()));
  for (RecordingInformation& recording : informationOfRecordings(variances)) {
    Information& information = recording.information;
    if (std::isfinite(information.log_determinant)) integrateOver(systematic, information);
    wheels[recording.wheels].add(information);
  }
  for (std::size_t i = 0; i < wheels.size(); ++i) add(priors_[i], wheels[i]);
  return wheels;
}

std::map<std::size_t, Eigen::VectorXd> VarianceComponents::recordingDraws(
    const Eigen::VectorXd& variances) const {
  const Eigen::DiagonalMatrix<double, Eigen::Dynamic> root(systematicVariances(variances).cwiseSqrt());
  const Eigen::Index p = root.rows();
  const std::vector<GainEstimate> common = gains(variances);
  std::map<std::size_t, Eigen::VectorXd> draws;
  for (const auto& [recording, wheels, information] : informationOfRecordings(variances)) {
    const Eigen::LLT<Eigen::MatrixXd> factor(Eigen::MatrixXd::Identity(p, p) +
                                             root * information.matrix * root);
    const Eigen::VectorXd left = information.vector - information.matrix * common[wheels].mean;
    const Eigen::VectorXd drawn = factor.solve(root * left);
    draws[recording] = root * drawn;
  }
  return draws;
}

double VarianceComponents::logLikelihood(const Eigen::VectorXd& variances) const {
  double sum = 0.0;
  for (const Information& wheels : informationOfWheels(variances)) {
    if (!std::isfinite(wheels.log_determinant)) return -std::numeric_limits<double>::infinity();
    const Eigen::LLT<Eigen::MatrixXd> factor(wheels.matrix);
    sum += static_cast<double>(wheels.rows) * std::log(2.0 * M_PI) + wheels.log_determinant +
           logDeterminant(factor) + wheels.square - wheels.vector.dot(factor.solve(wheels.vector));
  }
  return -0.5 * sum;
}

std::vector<GainEstimate> VarianceComponents::gains(const Eigen::VectorXd& variances) const {
  std::vector<GainEstimate> estimates;
  for (const Information& wheels : informationOfWheels(variances)) {
    const Eigen::LLT<Eigen::MatrixXd> factor(wheels.matrix);
    const Eigen::Index p = wheels.vector.size();
    estimates.push_back({factor.solve(wheels.vector), factor.solve(Eigen::MatrixXd::Identity(p, p))});
  }
  return estimates;
}

}  // namespace bs_car_odometry::tools
