#pragma once

#include <cstddef>
#include <string_view>

namespace bs_car_odometry::schema {

/// Levenshtein distance: letters to insert, remove or replace. Of names of any length their first 64 letters
/// are compared, which is more than a name of ours has.
std::size_t editDistance(std::string_view a, std::string_view b);

}  // namespace bs_car_odometry::schema
