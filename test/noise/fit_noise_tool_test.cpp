// fit_noise from the command line to its file: options, lists of bags, bags, the result on top of a vehicle.

#include "../../src/tools/fit_noise_options.hpp"
#include "../../src/tools/noise_report.hpp"
#include "../../src/tools/recorded_folder.hpp"
#include "../../src/tools/simulated_drive_bag.hpp"
#include "tools/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kVehicle =
    "vehicle: {wheelbase: 1.2, track: 1.2}\n"
    "encoders: {metres_per_tick: {front_left: 1e-5, front_right: 1e-5, rear_left: 1e-5, rear_right: 1e-5}}\n"
    "odometry: {axles: rear}\n";

FitNoiseOptions optionsOf(std::vector<std::string> words) {
  words.insert(words.begin(), "fit_noise");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  return fitNoiseOptions(static_cast<int>(argv.size()), argv.data());
}

TEST(FitNoiseOptions, areRead) {
  const TemporaryFolder folder;
  const std::string vehicle = folder.write("vehicle.yaml", kVehicle);
  const FitNoiseOptions options = optionsOf({"a.bag", "b.bag", "--config", vehicle, "--output", "n.yaml",
                                             "--truth-sigma", "0.003", "--estimate", "noise/wheel",
                                             "--estimate", "noise/lateral", "--set", "laser_sigma/yaw=0.01"});
  ASSERT_EQ(options.bags.size(), 2u);
  EXPECT_EQ(options.bags[1].path, "b.bag");
  EXPECT_NE(options.bags[0].recording, options.bags[1].recording);
  EXPECT_EQ(options.settings.errors.truth_position, 0.003);
  EXPECT_EQ(options.settings.errors.truth_yaw, 0.01) << "laser_sigma where no option says more";
  EXPECT_THAT(options.settings.noise, ElementsAre("noise/wheel", "noise/lateral"));
  EXPECT_FALSE(options.settings.errors.headings);
}

TEST(FitNoiseOptions, badOnesAreNamed) {
  const TemporaryFolder folder;
  const std::string vehicle = folder.write("vehicle.yaml", kVehicle);
  const auto error = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"--config", vehicle, "--output", "n.yaml"};
    words.insert(words.end(), more.begin(), more.end());
    return errorOf([&] { optionsOf(words); });
  };
  EXPECT_THAT(error({}), HasSubstr("no bags"));
  EXPECT_THAT(error({"a.bag", "--truth-sigma", "0"}), HasSubstr("--truth-sigma"));
  EXPECT_THAT(error({"a.bag", "--spacing", "-1"}), HasSubstr("--spacing"));
  EXPECT_THAT(error({"a.bag", "--places", "0"}), HasSubstr("--places"));
  EXPECT_THAT(error({"--runs", folder.file("none.yaml")}), HasSubstr("none.yaml cannot be read"));
  EXPECT_THAT(error({"--runs", folder.write("list.yaml", "[a.bag]")}), HasSubstr("map of wheels"));
  EXPECT_THAT(error({"--runs", folder.write("empty.yaml", "{}")}), HasSubstr("names no bags"));
}

TEST(FitNoiseOptions, aListSaysWhatBelongsTogether) {
  const TemporaryFolder folder;
  const std::string list = folder.write("runs.yaml", "june: {a: [1.bag, 2.bag]}\nmay: {a: [/tmp/3.bag]}\n");
  const std::vector<NoiseBag> bags = readRunsFile(list);
  ASSERT_EQ(bags.size(), 3u);
  EXPECT_EQ(bags[0].path, folder.file("1.bag"));
  EXPECT_EQ(bags[1].recording, "a");
  EXPECT_EQ(bags[1].wheels, "june");
  EXPECT_EQ(bags[2].path, "/tmp/3.bag");
}

TEST(LayeredConfig, laterFilesReplaceEarlierOnesAndSettingsBoth) {
  const TemporaryFolder folder;
  const std::string vehicle = folder.write("vehicle.yaml", kVehicle);
  const std::string noise =
      folder.write("noise.yaml", "noise: {wheel: 0.002, lateral: 0.001}\ngains: {rear: {k_b: 1.01}}\n");
  const Parameters parameters = loadVehicle({vehicle, noise}, {"noise/lateral=0.003"});
  EXPECT_EQ(parameters.noise.wheel.std(), 0.002);
  EXPECT_EQ(parameters.noise.lateral.std(), 0.003);
  EXPECT_EQ(parameters.vehicle.gains.rear.k_b, 1.01);
  EXPECT_EQ(parameters.vehicle.gains.rear.k_r, 1.0);
  const std::string uniform =
      folder.write("uniform.yaml", "gains:\nnoise: {wheel: {distribution: uniform, half_width: 0.003}}\n");
  EXPECT_EQ(loadVehicle({vehicle, uniform}, {}).noise.wheel.shape(), Distribution::Shape::kUniform);
  const std::string wrong = folder.write("wrong.yaml", "noise: {wheels: 0.002}\n");
  EXPECT_THAT(errorOf([&] { loadVehicle({vehicle, wrong}, {}); }), HasSubstr("noise/wheel"));
  EXPECT_THAT(errorOf([&] { loadVehicle({vehicle, folder.file("none")}, {}); }), HasSubstr("none"));
}

/// A result as a file, and what a vehicle is with it.
TEST(NoiseReport, isLoadedOnTopOfTheVehicle) {
  const TemporaryFolder folder;
  NoiseFit fit;
  fit.noise = {{"noise/wheel", 0.00123456, 1e-4}, {"noise/systematic/k_b", 0.0, 0.0}};
  fit.gain_names = {"gains/rear/k_r", "gains/rear/k_b"};
  fit.gains = {{"", Eigen::Vector2d(1.0123456, 0.98), Eigen::Matrix2d::Identity() * 1e-6,
                Eigen::Vector2d(1e-3, 1e-3)}};
  fit.next_drive = {{"noise/systematic/k_r", 0.0005}, {"noise/systematic/k_b", 0.0007}};
  const std::string vehicle = folder.write("vehicle.yaml", kVehicle);
  const Parameters parameters = loadVehicle({vehicle, folder.write("noise.yaml", noiseYaml(fit))}, {});
  EXPECT_NEAR(parameters.noise.wheel.std(), 0.00123456, 1e-6) << "four digits";
  EXPECT_EQ(parameters.noise.systematic.k_r.std(), 0.0005);
  EXPECT_EQ(parameters.noise.systematic.k_b.std(), 0.0007);
  EXPECT_EQ(parameters.vehicle.gains.rear.k_r, 1.0123456);
  EXPECT_EQ(parameters.vehicle.gains.rear.k_b, 0.98);
  EXPECT_THAT(noiseTable(fit), HasSubstr("nothing seen"));
}

TEST(NoiseReport, gainsOfSeveralWheelsAreForTheReader) {
  NoiseFit fit;
  fit.noise = {{"noise/wheel", 0.001, 1e-4}};
  fit.gain_names = {"gains/rear/k_r"};
  const Eigen::VectorXd one = Eigen::VectorXd::Constant(1, 1.0);
  fit.gains = {{"june", one, Eigen::MatrixXd::Identity(1, 1), one},
               {"may", one, Eigen::MatrixXd::Identity(1, 1), one}};
  EXPECT_THAT(noiseYaml(fit), HasSubstr("# june:"));
  EXPECT_THAT(noiseYaml(fit), ::testing::Not(HasSubstr("\ngains:")));
}

/// Bags of simulated drives, as `simulate` writes them, read back: with the truth, and with laser poses only.
class FitNoiseBags : public ::testing::Test {
 protected:
  std::string bag(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"simulate", "--scenario", "fig4",     "--config",        vehicle_,
                                   "--rate",   "20",         "--output", folder_.file(name)};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    simulate(static_cast<int>(argv.size()), argv.data());
    return folder_.file(name);
  }

  Parameters parameters() const { return loadVehicle({vehicle_}, {}); }

  TemporaryFolder folder_;
  std::string vehicle_{folder_.write("vehicle.yaml", kVehicle)};
};

TEST_F(FitNoiseBags, areReadWithTheirTruth) {
  const RecordedDrive drive = readDrive(bag("a.bag"), parameters(), TopicNames());
  EXPECT_EQ(drive.truth.size(), 301u) << "15 s at 20 Hz, both ends";
  EXPECT_EQ(drive.inputs.size(), 602u) << "wheels and front steering";
  EXPECT_EQ(drive.tracked_point.x, 0.0);
}

TEST_F(FitNoiseBags, giveLaserPosesWhereThereIsNoTruth) {
  const std::string path = bag("a.bag", {"--no-truth", "--set", "laser/x=0.8"});
  Parameters with_laser = parameters();
  with_laser.laser.x = 0.8;
  const RecordedDrive drive = readDrive(path, with_laser, TopicNames());
  EXPECT_EQ(drive.truth.size(), 151u) << "15 s at 10 Hz, both ends";
  EXPECT_NEAR(drive.truth.front().pose.x, 0.8, 0.1) << "the laser's pose: five standard deviations of 2 cm";
  EXPECT_EQ(drive.tracked_point.x, 0.8);
  with_laser.laser.frame = "laser";
  EXPECT_THAT(errorOf([&] { readDrive(path, with_laser, TopicNames()); }), HasSubstr("laser/frame"));
}

TEST_F(FitNoiseBags, withoutAnyTruthAreRefused) {
  const std::string path = bag("a.bag", {"--no-truth", "--laser-rate", "0"});
  EXPECT_THAT(errorOf([&] { readDrive(path, parameters(), TopicNames()); }), HasSubstr("laser_pose"));
}

/// Recordings kept as CSV: their names say what belongs together.
TEST(RecordedFolder, isReadRunByRun) {
  const TemporaryFolder folder;
  for (const std::string run : {"square-june-01", "square-june-02", "free-may-01"}) {
    std::filesystem::create_directory(folder.file(run));
    folder.write(run + "/wheels.csv", "t,rl,rr\n0,0,0\n1,100,100\n");
    folder.write(run + "/pose.csv", "t,x,y,yaw\n0,0,0,0\n1,0.1,0,0\n");
  }
  std::filesystem::create_directory(folder.file("notes"));
  const std::string settings_file = folder.write("sets.yaml",
                                                 "robot:\n  vehicle: v.yaml\n"
                                                 "  csv_to_bag: [--wheel-unit, tick_increments]\n"
                                                 "  wheels: {old: ['*-june-*']}\n");
  const RecordedFolderSettings settings = readRecordedFolderSettings(settings_file, "robot");
  EXPECT_EQ(settings.vehicle, folder.file("v.yaml"));
  const std::vector<RecordedRun> runs = readRecordedFolder(folder.file("."), settings);
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[0].drive.name, "free-may-01");
  EXPECT_EQ(runs[0].wheels, "");
  EXPECT_EQ(runs[1].wheels, "old");
  EXPECT_EQ(runs[1].recording, runs[2].recording);
  EXPECT_NE(runs[0].recording, runs[1].recording);
  EXPECT_THAT(errorOf([&] { readRecordedFolderSettings(settings_file, "car"); }), HasSubstr("'car'"));
  EXPECT_THAT(errorOf([&] { readRecordedFolder(folder.file("notes"), settings); }), HasSubstr("no runs"));
  EXPECT_THAT(errorOf([&] { readRecordedFolder(folder.file("none"), settings); }),
              HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
