// A bag with this package's topics from recordings kept as CSV: csv_to_bag --help.

#include "csv_to_bag_options.hpp"
#include "recording_bag.hpp"

int main(int argc, char** argv) {
  using namespace bs_car_odometry::tools;
  return runTool("csv_to_bag", [&] {
    const CsvToBagOptions options = csvToBagOptions(argc, argv);
    writeBag(options.output, readRecording(options.source), options.topics);
  });
}
