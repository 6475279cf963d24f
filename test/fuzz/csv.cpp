// Any text as the CSV of a recording's wheels, with any unit.

#include "bytes.hpp"
#include "csv_table.hpp"
#include "memory_file.hpp"
#include "tool.hpp"
#include "wheel_counters_from_csv.hpp"

namespace bs_car_odometry::fuzz {
namespace {

void read(const tools::CsvSource& source) {
  const std::vector<std::string> columns{"fl", "fr", "rl", "rr", "x", "y", "yaw"};
  const tools::CsvTable table(source.wheels_file, columns);
  require(table.rows() > 0, "no table is empty");
  for (const std::string& column : columns)
    if (table.has(column))
      require(tools::countersFromCsv(table, column, source).size() == table.rows(), "a counter for each row");
}

}  // namespace
}  // namespace bs_car_odometry::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bs_car_odometry;
  if (size == 0) return 0;
  static fuzz::MemoryFile file;
  file.write(fuzz::textOf(data + 1, size - 1));
  tools::CsvSource source;
  source.wheels_file = file.path();
  source.wheel_unit = static_cast<tools::WheelUnit>(data[0] % 5);
  source.wheel_radius = 0.3;
  try {
    fuzz::read(source);
  } catch (const tools::InputError& error) {
    fuzz::require(*error.what() != '\0', "it says why");
  }
  return 0;
}
