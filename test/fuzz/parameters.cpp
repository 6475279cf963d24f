// Any text as a file of parameters: refused with a sentence, or parameters that the odometry can be built
// from.

#include "bytes.hpp"

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"
#include "bs_car_odometry/parameters/load.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bs_car_odometry;
  try {
    LoadedParameters loaded = loadParameters(YAML::Load(fuzz::textOf(data, size)));
    // How much memory particles and history take is the user's to say.
    loaded.parameters.odometry.particles.count = 100;
    loaded.parameters.odometry.particles.threads = 1;
    loaded.parameters.relative_motion.history = Duration(0);
    const OdometryPipeline pipeline(toConfiguration(loaded.parameters));
  } catch (const ParameterError& error) {
    fuzz::require(*error.what() != '\0', "it says why");
  } catch (const YAML::Exception&) {
    // What is no YAML is refused by the reader of files.
  }
  return 0;
}
