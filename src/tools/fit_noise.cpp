// Noise and gains from drives with their truth: fit_noise --help.

#include "fit_noise_options.hpp"
#include "noise_report.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"

#include <fstream>
#include <iostream>

namespace {

using namespace bs_car_odometry::tools;
namespace calibration = bs_car_odometry::calibration;

std::vector<RecordedRun> readRuns(const FitNoiseOptions& options) {
  std::vector<RecordedRun> runs;
  Progress progress("reading", static_cast<double>(options.bags.size()));
  for (const NoiseBag& bag : options.bags) {
    runs.push_back({readDrive(bag.path, options.parameters, options.topics), bag.wheels, bag.recording});
    progress.update(static_cast<double>(runs.size()));
  }
  return runs;
}

void write(const std::string& text, calibration::AtomicFile& output) {
  std::ofstream file(output.temporaryPath(), std::ios::binary);
  file << text;
  file.close();
  if (!file) throw InputError("cannot write " + output.temporaryPath());
  output.commit();
}

}  // namespace

int main(int argc, char** argv) {
  return runTool("fit_noise", [&] {
    const FitNoiseOptions options = fitNoiseOptions(argc, argv);
    calibration::AtomicFile output(options.output);
    const NoiseFit fit = fitNoise(readRuns(options), options.parameters, options.settings);
    write(noiseYaml(fit), output);
    std::cout << noiseTable(fit);
  });
}
