#pragma once

#include <cstddef>
#include <string_view>
#include <utility>

namespace bs_car_odometry::schema {

/// Levenshtein distance: letters to insert, remove or replace. Of names of any length their first 64 letters
/// are compared, which is more than a name of ours has.
std::size_t editDistance(std::string_view a, std::string_view b);

/// Of two paths of parameters: the wrong group counts as one letter; among equals the one in the likelier
/// group is nearer.
std::pair<std::size_t, std::size_t> pathDistance(std::string_view a, std::string_view b);

}  // namespace bs_car_odometry::schema
