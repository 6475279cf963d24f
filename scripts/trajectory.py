"""Planar trajectories with covariances from ROS bags, and how far an estimate is from the truth."""

from dataclasses import dataclass

import numpy as np
import rosbag

# Entries of the 6 x 6 covariance of a pose (x, y, z, roll, pitch, yaw) that belong to the plane.
_PLANE = np.ix_([0, 1, 5], [0, 1, 5])


@dataclass
class Trajectory:
    """Poses over time; yaw is continuous, not wrapped."""

    stamps: np.ndarray       # [s], n
    poses: np.ndarray        # x [m], y [m], yaw [rad], n x 3
    covariances: np.ndarray  # n x 3 x 3

    def at(self, stamps):
        """Poses at other stamps, interpolated linearly."""
        return np.column_stack([np.interp(stamps, self.stamps, column) for column in self.poses.T])

    def between(self, begin, end):
        """The part with begin <= stamp <= end."""
        keep = (self.stamps >= begin) & (self.stamps <= end)
        return Trajectory(self.stamps[keep], self.poses[keep], self.covariances[keep])

    def distance(self):
        """Length of the path [m]."""
        return float(np.sum(np.hypot(*np.diff(self.poses[:, :2], axis=0).T)))

    def started_at(self, pose):
        """The same path, moved and turned so that it starts at `pose`. Covariances stay as they are."""
        turn = _rotation(pose[2] - self.poses[0, 2])
        positions = (self.poses[:, :2] - self.poses[0, :2]) @ turn.T + pose[:2]
        yaws = self.poses[:, 2] - self.poses[0, 2] + pose[2]
        return Trajectory(self.stamps, np.column_stack([positions, yaws]), self.covariances)


@dataclass
class Errors:
    """Estimate minus truth at the stamps of the estimate."""

    estimate: Trajectory
    differences: np.ndarray  # x [m], y [m], yaw [rad], n x 3

    def sigmas_from_truth(self):
        """Distance of the position and of the yaw from the truth, in standard deviations: n x 2."""
        covariances = self.estimate.covariances
        position = [_mahalanobis(d[:2], c[:2, :2]) for d, c in zip(self.differences, covariances)]
        yaw = [_mahalanobis(d[2:], c[2:, 2:]) for d, c in zip(self.differences, covariances)]
        return np.column_stack([position, yaw])

    def end_drift(self):
        """Distance between the two ends [m]."""
        return float(np.hypot(*self.differences[-1, :2]))

    def end_yaw(self):
        """Yaw of the estimate less that of the truth at the end [rad]."""
        return float(self.differences[-1, 2])


def read_odometry(bag_path, topic):
    """Trajectory of a nav_msgs/Odometry topic, named with or without a leading slash; None when there is none."""
    rows = []
    with rosbag.Bag(bag_path) as bag:
        for _, message, _ in bag.read_messages(topics=[topic, "/" + topic.lstrip("/")]):
            rows.append(_row(message))
    if not rows:
        return None
    stamps, poses, covariances = (np.array(column) for column in zip(*rows))
    poses[:, 2] = np.unwrap(poses[:, 2])
    return Trajectory(stamps, poses, covariances)


def compare(estimate, truth):
    """Errors of the estimate while there is truth."""
    estimate = estimate.between(truth.stamps[0], truth.stamps[-1])
    if not len(estimate.stamps):
        raise ValueError("the estimate and the truth do not overlap in time")
    differences = estimate.poses - truth.at(estimate.stamps)
    # Both yaws are continuous; only their whole turns may differ.
    differences[:, 2] -= 2.0 * np.pi * np.round(differences[0, 2] / (2.0 * np.pi))
    return Errors(estimate, differences)


def ellipse(pose, covariance, sigmas, points=60):
    """Outline of the position's ellipse: points x 2."""
    values, vectors = np.linalg.eigh(covariance[:2, :2])
    angle = np.linspace(0.0, 2.0 * np.pi, points)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return pose[:2] + sigmas * (circle * np.sqrt(np.maximum(values, 0.0))) @ vectors.T


def _row(message):
    pose = message.pose.pose
    yaw = 2.0 * np.arctan2(pose.orientation.z, pose.orientation.w)
    covariance = np.reshape(message.pose.covariance, (6, 6))[_PLANE]
    return message.header.stamp.to_sec(), [pose.position.x, pose.position.y, yaw], covariance


def _rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _mahalanobis(difference, covariance):
    """Zero without a difference; infinite where a difference meets no uncertainty."""
    if not np.any(np.abs(difference) > 1e-9):
        return 0.0
    try:
        return float(np.sqrt(difference @ np.linalg.solve(covariance, difference)))
    except np.linalg.LinAlgError:
        return float("inf")
