#pragma once

#include "csv_recording.hpp"
#include "tool.hpp"

#include <string>

namespace bs_car_odometry::tools {

/// Writes a recording as a bag, LZ4-compressed, in time order. The record time of a message is its stamp.
/// @throws InputError when the file cannot be written
void writeBag(const std::string& path, const Recording& recording, const TopicNames& topics);

}  // namespace bs_car_odometry::tools
