#pragma once

#include <Eigen/Core>

#include <complex>

namespace bs_car_odometry::test_support {

/// The moments of a pose in raw form, P1's step z' = z + D e^{i (theta + phi)}, theta' = theta + eta with
/// jointly Gaussian (D, eta, phi): (S4) of docs/model.md as it is derived there, for real D. An oracle for
/// (S4') of the package, which has the same contents in another form; it loses digits far from the origin.
class RawMoments {
 public:
  /// Starts from a Gaussian pose.
  RawMoments(const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance)
      : m_(mean.z()), s2_(covariance(2, 2)), a_(mean.x(), mean.y()) {
    const Complex c(covariance(0, 2), covariance(1, 2));
    P_ = std::exp(-kI * m_ - 0.5 * s2_) * (a_ - kI * c);
    Q_ = std::exp(kI * m_ - 0.5 * s2_) * (a_ + kI * c);
    M_ = covariance(0, 0) + covariance(1, 1) + std::norm(a_);
    W_ = covariance(0, 0) - covariance(1, 1) + 2.0 * kI * covariance(0, 1) + a_ * a_;
    T_ = c + a_ * m_;
  }

  /// @param mean        of (D, eta, phi)
  /// @param covariance  of the same
  void advance(const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance) {
    const Step step{mean, covariance};
    const Complex along = step.first(0.0, 1.0);  // E[D e^{i phi}]
    const Complex c1 = std::exp(kI * m_ - 0.5 * s2_);
    const Complex c2 = std::exp(2.0 * kI * m_ - 2.0 * s2_);
    const double D2 = mean(0) * mean(0) + covariance(0, 0);
    T_ += a_ * mean(1) + along * c1 * (m_ + kI * s2_) + step.withTurn() * c1;
    M_ += 2.0 * (P_ * std::conj(along)).real() + D2;
    W_ += 2.0 * along * Q_ + step.second(0.0, 2.0) * c2;
    P_ = P_ * step.chi(-1.0, 0.0) + step.first(-1.0, 1.0);
    Q_ = Q_ * step.chi(1.0, 0.0) + step.first(1.0, 1.0) * c2;
    a_ += along * c1;
    m_ += mean(1);
    s2_ += covariance(1, 1);
  }

  Eigen::Vector3d mean() const { return {a_.real(), a_.imag(), m_}; }

  Eigen::Matrix3d covariance() const {
    const double sum = M_ - std::norm(a_);
    const Complex difference = W_ - a_ * a_;
    const Complex c = T_ - a_ * m_;
    Eigen::Matrix3d covariance;
    covariance << 0.5 * (sum + difference.real()), 0.5 * difference.imag(), c.real(),  //
        0.5 * difference.imag(), 0.5 * (sum - difference.real()), c.imag(),            //
        c.real(), c.imag(), s2_;
    return covariance;
  }

 private:
  using Complex = std::complex<double>;
  static constexpr Complex kI{0.0, 1.0};

  /// Expectations over one step; (k, l) is the exponent k eta + l phi.
  struct Step {
    Eigen::Vector3d mean;
    Eigen::Matrix3d covariance;

    Complex chi(double k, double l) const {
      const double t = k * mean(1) + l * mean(2);
      const double var = k * k * covariance(1, 1) + 2.0 * k * l * covariance(1, 2) + l * l * covariance(2, 2);
      return std::exp(kI * t - 0.5 * var);
    }
    Complex shifted(double k, double l) const {
      return mean(0) + kI * (k * covariance(0, 1) + l * covariance(0, 2));
    }
    Complex first(double k, double l) const { return chi(k, l) * shifted(k, l); }
    Complex second(double k, double l) const {
      return chi(k, l) * (shifted(k, l) * shifted(k, l) + covariance(0, 0));
    }
    /// E[D eta e^{i phi}]
    Complex withTurn() const {
      return chi(0.0, 1.0) * (shifted(0.0, 1.0) * (mean(1) + kI * covariance(1, 2)) + covariance(0, 1));
    }
  };

  double m_;
  double s2_;
  Complex a_;
  Complex P_;
  Complex Q_;
  double M_;
  Complex W_;
  Complex T_;
};

}  // namespace bs_car_odometry::test_support
