// Row C10: a bag that cannot be used gives one sentence, with what was found and the remedy, and status 3.

#include "bad_bags.hpp"
#include "damaged_drive.hpp"

#include "../../src/tools/calibration_bags.hpp"
#include "../../src/tools/replay.hpp"

#include <gmock/gmock.h>

#include <iostream>

#include <algorithm>
#include <functional>
#include <sstream>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::HasSubstr;

struct Tool {
  const char* name;
  std::function<void(const std::string& bag, const std::string& output)> run;
};

void replayBag(const std::string& bag, const std::string& output) {
  replay(cycab(), TopicNames(), {bag, output, ""});
}

void bagDoctor(const std::string& bag, const std::string& /*output*/) {
  std::ostringstream findings;
  doctor::diagnose(bag, cycab(), TopicNames(), findings);
}

void calibrateBag(const std::string& bag, const std::string& output) {
  CalibrateOptions options;
  options.bags = {bag};
  options.parameters = cycab();
  options.output = output;
  filterBags(options, {});
}

class BadBags : public ::testing::TestWithParam<Tool> {};

TEST_P(BadBags, C10_areRefusedWithASentence) {
  const TemporaryFolder folder;
  const std::string output = folder.file("output");
  for (const BadBag& bag : writeBadBags(folder.file(""))) {
    std::cerr.clear();  // whatever a full pipe has done to it
    ::testing::internal::CaptureStderr();
    const int status = runTool(GetParam().name, [&] { GetParam().run(bag.path, output); });
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(status, kInputErrorStatus) << bag.name;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << bag.name << ": " << said;
    EXPECT_THAT(said, HasSubstr(bag.path));
    for (const std::string& part : bag.said) EXPECT_THAT(said, HasSubstr(part)) << bag.name;
    EXPECT_FALSE(std::filesystem::exists(output)) << bag.name;
  }
}

// Every tool that reads a bag has a line here.
INSTANTIATE_TEST_SUITE_P(Tools, BadBags,
                         ::testing::Values(Tool{"replay_bag", replayBag}, Tool{"bag_doctor", bagDoctor},
                                           Tool{"calibrate_bag", calibrateBag}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace bs_car_odometry::tools::testing
