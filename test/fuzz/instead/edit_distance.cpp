// Instead of parameters/edit_distance.cpp: most of the time would go into the search for the nearest of all
// names, functions of two names that read no file; names_test has known answers.

#include "../../../src/parameters/edit_distance.hpp"

namespace bs_car_odometry::schema {

std::size_t editDistance(std::string_view a, std::string_view b) {
  return a.size() > b.size() ? a.size() - b.size() : b.size() - a.size();
}

std::pair<std::size_t, std::size_t> pathDistance(std::string_view a, std::string_view b) {
  return {editDistance(a, b), 0};
}

}  // namespace bs_car_odometry::schema
