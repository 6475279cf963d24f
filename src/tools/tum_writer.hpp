#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <fstream>
#include <string>

namespace bs_car_odometry::tools {

/// Writes trajectories as trajectory evaluators read them: `t x y z qx qy qz qw` per line [s, m].
class TumWriter {
 public:
  explicit TumWriter(const std::string& path);  ///< @throws InputError
  void write(const OdometryUpdate& update);
  void close();  ///< @throws InputError when the disk did not take it

 private:
  std::string path_;
  std::ofstream file_;
};

}  // namespace bs_car_odometry::tools
