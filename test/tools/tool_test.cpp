// What the tools have in common.

#include "../../src/tools/tool.hpp"

#include "bs_car_odometry/parameters/load.hpp"
#include "capture_stderr.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::tools::testing {
namespace {

namespace po = boost::program_options;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::internal::GetCapturedStderr;

TEST(RunTool, returnsZeroWhenAllIsWell) {
  captureStderr();
  EXPECT_EQ(runTool("tool", [] {}), 0);
  EXPECT_EQ(GetCapturedStderr(), "");
}

TEST(RunTool, everyErrorIsOneLineAndStatus3) {
  captureStderr();
  EXPECT_EQ(runTool("tool", [] { throw InputError("a.csv:3: wrong"); }), 3);
  EXPECT_EQ(GetCapturedStderr(), "tool: a.csv:3: wrong\n");
  captureStderr();
  EXPECT_EQ(runTool("tool", [] { throw ParameterError("max_gap: wrong\nmax_speed: wrong"); }), 3);
  EXPECT_EQ(GetCapturedStderr(), "tool: max_gap: wrong; max_speed: wrong\n");
  captureStderr();
  EXPECT_EQ(runTool("tool", [] { throw 1; }), 3);
  EXPECT_EQ(GetCapturedStderr(), "tool: unknown error\n");
}

po::options_description someOptions() {
  po::options_description options("options");
  options.add_options()("input", po::value<std::string>()->required(), "the bag to read")(
      "speed", po::value<double>()->default_value(1.0), "[m/s]");
  return options;
}

po::variables_map parse(const std::vector<const char*>& arguments) {
  po::positional_options_description positional;
  positional.add("input", 1);
  return parseCommandLine(static_cast<int>(arguments.size()), arguments.data(), "tool IN.bag", someOptions(),
                          positional);
}

TEST(CommandLine, optionsPositionsAndRemappingsMayBeMixed) {
  const po::variables_map values =
      parse({"tool", "wheel_ticks:=/car/ticks", "in.bag", "odom:=o", "--speed", "-2", "__name:=x"});
  EXPECT_EQ(values["input"].as<std::string>(), "in.bag");
  EXPECT_EQ(values["speed"].as<double>(), -2.0);
}

TEST(CommandLine, errorsSayWhatIsWrong) {
  EXPECT_THAT(errorOf([] { parse({"tool"}); }), HasSubstr("'--input' is required"));
  EXPECT_THAT(errorOf([] { parse({"tool", "a.bag", "--sped", "1"}); }), HasSubstr("--sped"));
  EXPECT_THAT(errorOf([] { parse({"tool", "a.bag", "--speed", "fast"}); }), HasSubstr("'fast'"));
  EXPECT_THROW(parse({"tool", "a.bag", "b.bag"}), InputError);
  EXPECT_THROW(parse({"tool", "a.bag", "--spee", "1"}), InputError) << "short forms are not guessed";
}

TEST(CommandLineDeathTest, helpEndsWithZeroWithoutTheRequiredOptions) {
  EXPECT_EXIT(parse({"tool", "--help"}), ::testing::ExitedWithCode(0), "");
}

TopicNames topicNames(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "tool");
  return TopicNames(static_cast<int>(arguments.size()), arguments.data(), {"wheel_ticks", "odom"});
}

TEST(TopicNames, aLeadingSlashMakesNoDifference) {
  const TopicNames names = topicNames({"--output", "out.bag"});
  EXPECT_EQ(names.topic("wheel_ticks"), "/wheel_ticks");
  EXPECT_TRUE(names.matches("wheel_ticks", "wheel_ticks"));
  EXPECT_TRUE(names.matches("/wheel_ticks", "wheel_ticks"));
  EXPECT_FALSE(names.matches("/car/wheel_ticks", "wheel_ticks"));
  EXPECT_THAT(names.spellings("odom"), ElementsAre("/odom", "odom"));
}

TEST(TopicNames, renamedOnesReplaceTheirName) {
  for (const char* argument : {"wheel_ticks:=/car/ticks", "/wheel_ticks:=car/ticks"}) {
    const TopicNames names = topicNames({"in.bag", argument, "__log:=file"});
    EXPECT_EQ(names.topic("wheel_ticks"), "/car/ticks");
    EXPECT_TRUE(names.matches("car/ticks", "wheel_ticks"));
    EXPECT_FALSE(names.matches("/wheel_ticks", "wheel_ticks"));
    EXPECT_EQ(names.topic("odom"), "/odom");
  }
}

TEST(TopicNames, mistakesAreNamed) {
  EXPECT_THAT(errorOf([] { topicNames({"whel_ticks:=a"}); }), HasSubstr("known: wheel_ticks, odom"));
  EXPECT_THAT(errorOf([] { topicNames({"odom:="}); }), HasSubstr("the topic is missing"));
  EXPECT_THAT(errorOf([] { topicNames({"odom:=a", "odom:=b"}); }), HasSubstr("renamed twice"));
}

TEST(LoadVehicle, settingsApplyLastAndWarningsAreShown) {
  const TemporaryFolder folder;
  const std::string file = folder.write(
      "car.yaml",
      "vehicle: {wheelbase: 1.2, track: 1.2}\nmax_speed: 5\nmax_gpa: 1\n"
      "encoders: {metres_per_tick: {front_left: 1, front_right: 1, rear_left: 1, rear_right: 1}}\n");
  captureStderr();
  const Parameters parameters = loadVehicle({file}, {"max_speed=6", "vehicle/name=a=b"});
  EXPECT_THAT(GetCapturedStderr(), HasSubstr("nearest known one is max_gap"));
  EXPECT_EQ(parameters.limits.max_speed, 6.0);
  EXPECT_EQ(parameters.vehicle.name, "a=b");
  const Distribution wheel =
      loadVehicle({file}, {"noise/wheel={distribution: uniform, half_width: 0.01}"}).noise.wheel;
  EXPECT_EQ(wheel.shape(), Distribution::Shape::kUniform);
  EXPECT_EQ(wheel.scale(), 0.01);
  EXPECT_THAT(errorOf([&] { loadVehicle({file}, {"max_speed"}); }), HasSubstr("--set max_speed"));
  EXPECT_THROW(loadVehicle({file}, {"max_sped=1"}), ParameterError);
}

TEST(Progress, isSilentUnlessStandardErrorIsATerminal) {
  captureStderr();
  {
    Progress progress("reading", 10.0);
    for (int i = 0; i <= 10; ++i) progress.update(i);
  }
  EXPECT_EQ(GetCapturedStderr(), "");
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
