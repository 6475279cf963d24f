#include "edit_distance.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace bs_car_odometry::schema {
namespace {

std::string_view lastPart(std::string_view path) { return path.substr(path.rfind('/') + 1); }

}  // namespace

std::size_t editDistance(std::string_view a, std::string_view b) {
  constexpr std::size_t kMostLetters = 64;
  a = a.substr(0, kMostLetters);
  b = b.substr(0, kMostLetters);
  std::array<std::size_t, kMostLetters + 1> row;
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min(std::min(row[j], row[j - 1]) + 1, replaced);
    }
  }
  return row[b.size()];
}

std::pair<std::size_t, std::size_t> pathDistance(std::string_view a, std::string_view b) {
  const std::size_t whole = editDistance(a, b);
  return {std::min(whole, editDistance(lastPart(a), lastPart(b)) + 1), whole};
}

}  // namespace bs_car_odometry::schema
