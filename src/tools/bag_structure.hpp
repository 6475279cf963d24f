#pragma once

#include <string>

namespace bs_car_odometry::tools {

/// Checks every length, count and offset of a bag that rosbag will follow when it opens and reads it. rosbag
/// believes them, and reads or allocates beyond the file: one wrong bit can end the process. The content of a
/// compressed chunk is not looked into: its checksum stands for it. What is no file, or empty, is left to
/// rosbag.
/// @throws rosbag::BagException saying what does not fit
void checkBagStructure(const std::string& path);

}  // namespace bs_car_odometry::tools
