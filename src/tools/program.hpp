#pragma once

#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// A program in the same folder as the running one; rosrun finds both there.
std::string besideThisProgram(const std::string& name);

/// Runs a program to its end; it writes where this one does.
/// @param command  path of the program, then its arguments
/// @throws InputError when it cannot be run or does not end with status 0
void runProgram(const std::vector<std::string>& command);

}  // namespace bs_car_odometry::tools
