#pragma once

#include "bs_car_odometry/calibration/filter.hpp"

#include <memory>
#include <variant>
#include <vector>

namespace bs_car_odometry::calibration {

/// The beginning of a drive, to be gone through again with what it has shown. While the gains are still far
/// off, the filter works out its derivatives for another motion than the true one: wheels of unequal gains on
/// a straight line seem to turn, and k_b to be seen by it. After 1, 2, 4, 8 and 16 m everything so far is
/// done anew, from the same prior, with the derivatives at the present values (docs/calibration.md, 3).
class Rehearsal {
 public:
  /// @param filter  just begun
  explicit Rehearsal(const Filter& filter) : begun_(filter.clone()) {}

  void add(const MeasuredStep& step);
  void add(const LaserPose& laser, double lead) { events_.push_back(Taken{laser, lead}); }

  /// True when the next distance is reached.
  bool isDue() const { return distance_ >= next_; }

  /// A filter that has gone through everything with its derivatives at `values`; none when it cannot.
  std::unique_ptr<Filter> repeat(const ParameterVector& values);

  /// True when nothing is to be repeated any more.
  bool isOver() const;

 private:
  struct Taken {
    LaserPose laser;
    double lead;
  };

  std::unique_ptr<Filter> begun_;
  std::vector<std::variant<MeasuredStep, Taken>> events_;
  double distance_{0.0};  ///< [m], of the fastest wheel
  double next_{1.0};      ///< [m]
};

}  // namespace bs_car_odometry::calibration
