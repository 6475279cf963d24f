// The tool `consistency`: its table, its CSV, what it refuses.

#include "../../src/tools/simulated_consistency.hpp"

#include "../../src/tools/program.hpp"
#include "../../src/tools/tool.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>
#include <sstream>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStdout;

const char* const kCar =
    "vehicle: {wheelbase: 1.2, track: 1.2}\n"
    "encoders: {metres_per_tick: {front_left: 1e-4, front_right: 1e-4, rear_left: 1e-4, rear_right: 1e-4}}\n";

class ConsistencyTool : public ::testing::Test {
 protected:
  /// What the tool prints. Few drives, since it is the table that is tested.
  std::string run(const std::vector<std::string>& options) const {
    std::vector<std::string> words{"consistency", "--config", car_, "--runs", "4"};
    words.insert(words.end(), options.begin(), options.end());
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    CaptureStdout();
    try {
      consistency(static_cast<int>(arguments.size()), arguments.data());
    } catch (...) {
      GetCapturedStdout();
      throw;
    }
    return GetCapturedStdout();
  }

  std::string errorOfRun(const std::vector<std::string>& options) const {
    return errorOf([&] { run(options); });
  }

  std::string csv(const std::vector<std::string>& options) const {
    const std::string path = folder_.file("out.csv");
    std::vector<std::string> all{"--csv", path};
    all.insert(all.end(), options.begin(), options.end());
    run(all);
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  TemporaryFolder folder_;
  std::string car_{folder_.write("car.yaml", kCar)};
};

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST_F(ConsistencyTool, oneRowForEachCombination) {
  const std::string table = run({"--scenario", "fig4,circle", "--axles", "all", "--geometry", "all"});
  EXPECT_THAT(table, HasSubstr("4 drives each"));
  EXPECT_THAT(table, HasSubstr("\n| fig4 | ackermann | both | first_order | "));
  EXPECT_THAT(table, HasSubstr("\n| circle | pivot | rear | first_order | "));
  EXPECT_EQ(lines(table), 4u + 2u * 2u * 3u);
}

TEST_F(ConsistencyTool, theVehicleFileDecidesWhatIsNotAskedFor) {
  const std::string table = run(
      {"--scenario", "fig4", "--set", "odometry/axles=rear", "--set", "odometry/uncertainty=exact_moments"});
  EXPECT_THAT(table, HasSubstr("\n| fig4 | ackermann | rear | exact_moments | "));
}

TEST_F(ConsistencyTool, allScenariosAreThoseWithoutFaults) {
  const std::string table = run({"--scenario", "all"});
  EXPECT_THAT(table, HasSubstr("| slalom_eight |"));
  EXPECT_THAT(table, Not(HasSubstr("wheel_spin")));
}

TEST_F(ConsistencyTool, theCsvHasEveryPlace) {
  const std::string text = csv({"--scenario", "fig4", "--places", "3"});
  EXPECT_EQ(lines(text), 1u + 3u);
  std::istringstream stream(text);
  std::string head;
  std::string row;
  std::getline(stream, head);
  std::getline(stream, row);
  EXPECT_THAT(head, StartsWith("scenario,axle_geometry,axles,method,drives,distance,sigma_x"));
  EXPECT_THAT(row, StartsWith("fig4,ackermann,both,first_order,4,6."));  // a third of 19 m
  EXPECT_EQ(std::count(head.begin(), head.end(), ','), std::count(row.begin(), row.end(), ','));
}

TEST_F(ConsistencyTool, theThreadsMakeNoDifference) {
  EXPECT_EQ(csv({"--scenario", "fig4", "--threads", "1"}), csv({"--scenario", "fig4", "--threads", "3"}));
}

TEST_F(ConsistencyTool, gainsAreDrawnUnlessRefused) {
  const std::string drawn = csv({"--scenario", "fig4"});
  EXPECT_EQ(drawn, csv({"--scenario", "fig4", "--draw-gains"}));
  EXPECT_NE(drawn, csv({"--scenario", "fig4", "--no-draw-gains"}));
}

TEST_F(ConsistencyTool, mistakesAreNamed) {
  EXPECT_THAT(errorOfRun({}), HasSubstr("'--scenario' is required"));
  EXPECT_THAT(errorOfRun({"--scenario", "fig5"}), HasSubstr("unknown scenario 'fig5'"));
  EXPECT_THAT(errorOfRun({"--scenario", "fig4", "--method", "magic"}), HasSubstr("odometry/uncertainty"));
  EXPECT_THAT(errorOfRun({"--scenario", "fig4", "--rate", "0"}), HasSubstr("--rate must be"));
  EXPECT_THAT(errorOfRun({"--scenario", "fig4", "--draw-gains", "--no-draw-gains"}), HasSubstr("exclude"));
  EXPECT_THAT(errorOfRun({"--scenario", "fig4", "--csv", folder_.file("none/out.csv")}),
              HasSubstr("none/out.csv cannot be written"));
  EXPECT_EQ(folder_.files(), 1u) << "nothing but the vehicle file is left behind";
}

TEST(RunProgram, saysWhatWentWrong) {
  runProgram({"/bin/true"});
  EXPECT_THAT(errorOf([] { runProgram({"/bin/false"}); }), HasSubstr("/bin/false failed"));
  EXPECT_THAT(errorOf([] { runProgram({"/bin/no_such_program"}); }),
              HasSubstr("cannot run /bin/no_such_program"));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
