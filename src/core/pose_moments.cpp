#include "bs_car_odometry/core/pose_moments.hpp"

#include <cmath>

namespace bs_car_odometry {

namespace {

constexpr std::complex<double> kI(0.0, 1.0);

/// 1 - e^{-z}. Its argument is the heading variance of one step, nearly always tiny.
double oneMinusExp(double z) {
  if (z > 1e-3) return -std::expm1(-z);
  return z * (1.0 - z / 2.0 * (1.0 - z / 3.0 * (1.0 - z / 4.0 * (1.0 - z / 5.0))));
}

/// How far expectations of e^{i theta} fall short of 1. All of them are close to 1 for a drive that is known
/// well, so their complements are what is worked with.
struct Attenuation {
  double E1;           ///< e^{-s2/2}
  double turn_loss;    ///< 1 - e^{-s2 - lambda s}
  double square_loss;  ///< 1 - e^{-s2 - lambda^2 s}
};

Attenuation attenuation(double heading_variance, double turn_variance, double lambda) {
  const double complement = std::expm1(-0.5 * heading_variance);
  const double E1 = 1.0 + complement;
  const double heading_loss = -complement * (2.0 + complement);  // 1 - e^{-s2}
  const auto lossWith = [&](double z) { return heading_loss + E1 * E1 * oneMinusExp(z); };
  return {E1, lossWith(lambda * turn_variance), lossWith(lambda * lambda * turn_variance)};
}

}  // namespace

GaussianStep GaussianStep::ofBody(const BodyMotion& t, const Eigen::Matrix3d& P) {
  const double half = 0.5 * t.z();
  const double chord = sinc(half);
  const double slope = 0.5 * sincDerivative(half);
  const double jx = slope * t.x();
  const double jy = slope * t.y();
  // J P J^T for J = [chord 0 jx; 0 chord jy; 0 0 1].
  GaussianStep step;
  step.displacement = {chord * t.x(), chord * t.y()};
  step.turn = t.z();
  const double x_eta = chord * P(0, 2) + jx * P(2, 2);
  const double y_eta = chord * P(1, 2) + jy * P(2, 2);
  const double xx = chord * (chord * P(0, 0) + jx * P(0, 2)) + jx * x_eta;
  const double xy = chord * (chord * P(0, 1) + jx * P(1, 2)) + jy * x_eta;
  const double yy = chord * (chord * P(1, 1) + jy * P(1, 2)) + jy * y_eta;
  step.covariance << xx, xy, x_eta, xy, yy, y_eta, x_eta, y_eta, P(2, 2);
  return step;
}

void PoseMoments::reset(const Pose2& mean, const Eigen::Matrix3d& covariance) {
  mean_ = {mean.x, mean.y};
  heading_ = mean.yaw;
  heading_variance_ = covariance(2, 2);
  var_x_ = covariance(0, 0);
  var_y_ = covariance(1, 1);
  cov_xy_ = covariance(0, 1);
  position_heading_ = {covariance(0, 2), covariance(1, 2)};
  makeGaussian();
}

void PoseMoments::makeGaussian() {
  forward_ = kI * std::exp(-0.5 * heading_variance_) * position_heading_;
  backward_ = -forward_;
}

/// (S4') with lambda in the place of its 1/2.
void PoseMoments::advance(const GaussianStep& step) {
  const double lambda = step.direction;
  const Complex D = step.displacement;
  const double s = step.covariance(2, 2);
  const Complex C(step.covariance(0, 2), step.covariance(1, 2));
  const double V = step.covariance(0, 0) + step.covariance(1, 1);
  const Complex K(step.covariance(0, 0) - step.covariance(1, 1), 2.0 * step.covariance(0, 1));

  const auto [E1, turn_loss, square_loss] = attenuation(heading_variance_, s, lambda);
  const double direction = heading_ + lambda * step.turn;
  const Complex R =
      Complex(std::cos(direction), std::sin(direction)) * (1.0 - oneMinusExp(0.5 * lambda * lambda * s));

  const Complex iC = kI * C;
  const Complex G = D + lambda * iC;
  const Complex RG = R * G;
  const double spread = std::norm(D) * square_loss + V - (1.0 - square_loss) * (std::norm(G) - std::norm(D));
  const double M = 2.0 * (std::conj(backward_) * RG).real() + spread;
  const Complex twice = D + 2.0 * lambda * iC;
  const Complex W = 2.0 * forward_ * RG +
                    R * R * (E1 * E1) *
                        (lambda * iC * (2.0 * D + 3.0 * lambda * iC) + K - square_loss * (twice * twice + K));
  var_x_ += 0.5 * (M + W.real());
  var_y_ += 0.5 * (M - W.real());
  cov_xy_ += 0.5 * W.imag();
  position_heading_ += R * E1 * (kI * (heading_variance_ + lambda * s) * G + C);

  const double turn_decay = 1.0 - oneMinusExp(0.5 * s);
  const double f = lambda == 0.5 ? 1.0 : std::exp(-(0.5 - lambda) * s);
  const double e = 1.0 - turn_loss;
  backward_ = turn_decay * backward_ + f * (R * (turn_loss * D + (lambda - 1.0 - lambda * e) * iC));
  forward_ = turn_decay * forward_ + f * e * (R * (((1.0 + lambda) * e - lambda) * iC - turn_loss * D));
  mean_ += E1 * RG;
  heading_ += step.turn;
  heading_variance_ += s;
}

void PoseMoments::add(const Eigen::Matrix3d& covariance) {
  const Complex C(covariance(0, 2), covariance(1, 2));
  const double decay = std::exp(-0.5 * covariance(2, 2));
  const Complex share = kI * (decay * std::exp(-0.5 * heading_variance_)) * C;
  backward_ = decay * backward_ - share;
  forward_ = decay * forward_ + share;
  var_x_ += covariance(0, 0);
  var_y_ += covariance(1, 1);
  cov_xy_ += covariance(0, 1);
  position_heading_ += C;
  heading_variance_ += covariance(2, 2);
}

Eigen::Matrix3d PoseMoments::covariance() const {
  const Complex& T = position_heading_;
  Eigen::Matrix3d covariance;
  covariance << var_x_, cov_xy_, T.real(),  //
      cov_xy_, var_y_, T.imag(),            //
      T.real(), T.imag(), heading_variance_;
  return covariance;
}

}  // namespace bs_car_odometry
