#pragma once

#include "drive.hpp"

namespace bs_car_odometry::drives {

/// Mean error of the odometry at the end of a noise-free drive, were its readings noisy, to second order:
/// (x, y, yaw) in odom [m, m, rad]. The covariance is of first order, where the mean error is nil. Two things
/// make it:
///
/// - Heading noise shortens the mean of a path: a displacement d after which the heading has the variance v
/// points on
///   average exp(-v/2) as far.
/// - A step's motion f is not linear in its readings x. With independent errors of standard deviation s_i,
///       E f(x + e) - f(x) = sum_i (f(x + s_i) + f(x - s_i) - 2 f(x))/2.
///   Model (B) of one axle has such a mean in the heading; as the noise of a wheel over a step d is c
///   sqrt(d), it is about the same in every step, so it grows with the message rate.
Eigen::Vector3d meanError(const OdometryConfiguration& configuration, const std::vector<Sample>& drive);

}  // namespace bs_car_odometry::drives
