// calibrate_bag from end to end, on recorded drives of the simulated car: what it writes, what it refuses,
// with which exit status (docs/reliability.md, rows C4, C5, C7, C9, C10).

#include "../../src/tools/calibrate.hpp"

#include "../../src/tools/calibration_table.hpp"
#include "../../src/tools/simulated_drive_bag.hpp"
#include "../../src/tools/tool.hpp"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/calibration/result_file.hpp"
#include "capture_stderr.hpp"
#include "temporary_folder.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gmock/gmock.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace bs_car_odometry::tools::testing {
namespace {

using calibration::CalibrationResult;
using calibration::kCount;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStderr;
using ::testing::internal::GetCapturedStdout;
using Words = std::vector<std::string>;

const char* const kCar =
    "vehicle: {name: test, wheelbase: 1.2, track: 1.2}\n"
    "encoders: {metres_per_tick: {front_left: 1e-4, front_right: 1e-4, rear_left: 1e-4, rear_right: 1e-4}}\n"
    "odometry: {axles: rear}\n";

std::vector<const char*> pointers(const Words& words) {
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  return arguments;
}

/// What a run of the tool has left.
struct Outcome {
  int status;
  std::string output;
  std::string error;
};

class CalibrateTool : public ::testing::Test {
 protected:
  /// A recorded drive; the true gains are (1.02, 0.99, 1.03) unless an option says otherwise.
  std::string drive(const std::string& name, const std::string& scenario, const Words& options = {}) const {
    Words words{"simulate", "--scenario", scenario, "--config", car_, "--output", folder_.file(name)};
    words.insert(words.end(), options.begin(), options.end());
    CaptureStdout();
    const auto arguments = pointers(words);
    simulate(static_cast<int>(arguments.size()), arguments.data());
    GetCapturedStdout();
    return folder_.file(name);
  }

  Outcome calibrateBags(const Words& options) const {
    Words words{"calibrate_bag", "--config", car_, "--output", file_};
    words.insert(words.end(), options.begin(), options.end());
    const auto arguments = pointers(words);
    CaptureStdout();
    captureStderr();
    Outcome outcome;
    outcome.status =
        runTool("calibrate_bag", [&] { calibrate(static_cast<int>(arguments.size()), arguments.data()); });
    outcome.output = GetCapturedStdout();
    outcome.error = GetCapturedStderr();
    return outcome;
  }

  Parameters parameters() const { return loadVehicle({car_}, {}); }
  CalibrationResult result() const { return calibration::readCalibrationFile(file_, parameters()); }
  bool written() const { return std::filesystem::exists(file_); }

  TemporaryFolder folder_;
  std::string car_{folder_.write("car.yaml", kCar)};
  std::string file_{folder_.file("cal.yaml")};
};

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Standard deviation that a row of the printed table shows.
double printedDeviation(const std::string& output, const std::string& parameter) {
  std::istringstream row(output.substr(output.find("\n" + parameter) + 1));
  std::string name;
  double value = 0.0;
  double deviation = 0.0;
  row >> name >> value >> deviation;
  return deviation;
}

void expectTruth(const CalibrationResult& result) {
  constexpr std::array<std::size_t, 3> kGains{systematic::kRearRight, systematic::kRearLeft,
                                              systematic::kRearTrack};
  constexpr std::array<double, 3> kTruth{1.02, 0.99, 1.03};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(kGains[i]);
    ASSERT_TRUE(result.listed[kGains[i]]);
    // Four standard deviations: three values of one drive with a fixed seed.
    EXPECT_NEAR(result.values[k], kTruth[i], 4.0 * std::sqrt(result.covariance(k, k)));
    EXPECT_LT(std::sqrt(result.covariance(k, k)), 0.01) << "the bound of fig4 is below 0.009";
  }
}

TEST_F(CalibrateTool, aDriveGivesTheGains) {
  const Outcome outcome = calibrateBags({drive("a.bag", "fig4")});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(outcome.output, HasSubstr("rear/k_b"));
  EXPECT_THAT(outcome.output, HasSubstr("filter"));
  EXPECT_THAT(outcome.output, HasSubstr("noise/wheel"));
  EXPECT_THAT(outcome.output, HasSubstr("written: " + file_));
  expectTruth(result());
}

TEST_F(CalibrateTool, theFilterAloneGivesThemToo) {
  const Outcome outcome = calibrateBags({drive("a.bag", "fig4"), "--no-refine"});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(outcome.output, Not(HasSubstr("noise/wheel")));
  expectTruth(result());
}

TEST_F(CalibrateTool, severalBagsAreOneCalibration) {
  const Outcome first = calibrateBags({drive("a.bag", "fig4", {"--seed", "1"}), "--no-refine"});
  const double one = printedDeviation(first.output, "rear/k_b");
  const Outcome both = calibrateBags({folder_.file("a.bag"), drive("b.bag", "fig4", {"--seed", "2"})});
  EXPECT_EQ(both.status, 0) << both.error;
  EXPECT_THAT(both.output, HasSubstr("by the other bags"));
  // Twice the same drive tells twice as much; noise that is estimated may differ by some ten percent.
  EXPECT_NEAR(printedDeviation(both.output, "rear/k_b"), one / std::sqrt(2.0), 0.15 * one);
  expectTruth(result());
  EXPECT_EQ(result().data.bags, (Words{"a.bag", "b.bag"}));
}

/// The prior is 0.02: against it, what the noise of the wheels feigns of turns is below the one percent asked
/// for. (Each 0.1 m between two laser poses feigns 2 mrad of turn, and 200 of them some 20 units of
/// information: 4 % of a prior of 0.05, 0.5 % of this one.)
TEST_F(CalibrateTool, C5_aStraightDriveIsRefusedAndKeepsThePriorOfTheTrack) {
  const Outcome outcome = calibrateBags({drive("s.bag", "straight"), "--set", "calibration/prior/k_b=0.02"});
  EXPECT_EQ(outcome.status, kNotObservedStatus);
  EXPECT_THAT(outcome.error, HasSubstr("not observed yet: rear/k_b: turn "));
  EXPECT_FALSE(written());
  EXPECT_NEAR(printedDeviation(outcome.output, "rear/k_b"), 0.02, 0.01 * 0.02);
}

TEST_F(CalibrateTool, C5_allowPartialSavesWhatWasObserved) {
  const Outcome outcome =
      calibrateBags({drive("s.bag", "straight"), "--set", "calibration/allow_partial=true"});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_TRUE(result().listed[systematic::kRearRight]);
  EXPECT_TRUE(result().listed[systematic::kRearLeft]);
  EXPECT_FALSE(result().listed[systematic::kRearTrack]);
  EXPECT_TRUE(result().not_observed[systematic::kRearTrack]);
}

TEST_F(CalibrateTool, C5_aParkedCarShowsNothingEvenWithAllowPartial) {
  const Outcome outcome =
      calibrateBags({drive("p.bag", "straight", {"--duration", "2", "--speed-factor", "0.01"}), "--set",
                     "calibration/allow_partial=true"});
  EXPECT_EQ(outcome.status, kNotObservedStatus) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("drive "));
  EXPECT_FALSE(written());
}

/// The bag's counters mean twice, or half, of what the vehicle's file says.
TEST_F(CalibrateTool, C7_aWrongRadiusIsNamed) {
  const std::string bag = drive("a.bag", "fig4");
  for (const char* metres : {"2e-4", "5e-5"}) {
    Words options{bag};
    for (const char* wheel : {"front_left", "front_right", "rear_left", "rear_right"}) {
      options.emplace_back("--set");
      options.push_back("encoders/metres_per_tick/" + std::string(wheel) + "=" + metres);
    }
    const Outcome outcome = calibrateBags(options);
    EXPECT_EQ(outcome.status, kInputErrorStatus) << metres;
    EXPECT_THAT(outcome.error, HasSubstr("radius"));
    EXPECT_THAT(outcome.error, HasSubstr("ticks per turn"));
    EXPECT_FALSE(written());
  }
}

TEST_F(CalibrateTool, theObjectiveIsChosenAndNoted) {
  const std::string bag = drive("a.bag", "slalom_eight");
  ASSERT_EQ(calibrateBags({bag}).status, 0);
  const CalibrationResult likelihood = result();
  EXPECT_THAT(textOf(file_), HasSubstr("objective: likelihood"));
  const Outcome outcome = calibrateBags({bag, "--objective", "path"});
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(textOf(file_), HasSubstr("objective: path"));
  const CalibrationResult path = result();
  EXPECT_EQ(path.listed, likelihood.listed);
  EXPECT_NE(path.values, likelihood.values);
  for (const std::size_t p : {systematic::kRearRight, systematic::kRearLeft, systematic::kRearTrack}) {
    const auto i = static_cast<Eigen::Index>(p);
    const double deviation = std::sqrt(path.covariance(i, i));
    EXPECT_GT(deviation, std::sqrt(likelihood.covariance(i, i)));  // by the noise model it knows less
    EXPECT_NEAR(path.values[i], likelihood.values[i], 4.0 * deviation);
  }
}

TEST_F(CalibrateTool, theObjectiveOfAPathKeepsWhatItDoesNotShow) {
  const std::string bag = drive("s.bag", "straight");
  const Outcome refused = calibrateBags({bag, "--objective", "path"});
  EXPECT_EQ(refused.status, kNotObservedStatus) << refused.error;
  EXPECT_FALSE(written());
  const Outcome partial =
      calibrateBags({bag, "--objective", "path", "--set", "calibration/allow_partial=true"});
  EXPECT_EQ(partial.status, 0) << partial.error;
  EXPECT_FALSE(result().listed[systematic::kRearTrack]);
  EXPECT_TRUE(result().not_observed[systematic::kRearTrack]);
  EXPECT_TRUE(result().listed[systematic::kRearRight]);
}

TEST_F(CalibrateTool, anObjectiveThatDoesNotExistIsRefused) {
  const std::string bag = drive("a.bag", "fig4");
  EXPECT_THAT(calibrateBags({bag, "--objective", "drift"}).error,
              HasSubstr("likelihood or path, not 'drift'"));
  const Outcome nothing = calibrateBags({bag, "--objective", "path", "--no-refine"});
  EXPECT_EQ(nothing.status, kInputErrorStatus);
  EXPECT_THAT(nothing.error, HasSubstr("--no-refine"));
}

/// The same messages, with a transform before them.
void addTransform(const std::string& from, const std::string& to,
                  const geometry_msgs::TransformStamped& mount) {
  const rosbag::Bag in(from);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(mount);
  rosbag::View view(in);
  out.write("/tf_static", view.getBeginTime(), message);
  for (const rosbag::MessageInstance& instance : rosbag::View(in))
    out.write(instance.getTopic(), instance.getTime(), instance, instance.getConnectionHeader());
}

TEST_F(CalibrateTool, C9_theMountComesFromTf) {
  const std::string bag = drive("a.bag", "fig4", {"--set", "laser/x=0.5", "--set", "laser/yaw=0.3"});
  ASSERT_EQ(calibrateBags({bag, "--no-refine", "--set", "laser/x=0.5", "--set", "laser/yaw=0.3"}).status, 0);
  const CalibrationResult given = result();
  geometry_msgs::TransformStamped mount;
  mount.header.frame_id = "base_link";
  mount.child_frame_id = "laser";
  mount.transform.translation.x = 0.5;
  mount.transform.rotation.z = std::sin(0.15);
  mount.transform.rotation.w = std::cos(0.15);
  addTransform(bag, folder_.file("tf.bag"), mount);
  const Outcome outcome =
      calibrateBags({folder_.file("tf.bag"), "--no-refine", "--set", "laser/frame=laser"});
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  // The mount goes through a quaternion; its rounding is magnified by a thousand at most.
  EXPECT_LT((result().values - given.values).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_F(CalibrateTool, C9_aMountThatTfDoesNotKnowIsRefused) {
  const Outcome outcome = calibrateBags({drive("a.bag", "fig4"), "--set", "laser/frame=laser"});
  EXPECT_EQ(outcome.status, kInputErrorStatus);
  EXPECT_THAT(outcome.error, HasSubstr("no transform from 'base_link' to 'laser'"));
  EXPECT_FALSE(written());
}

TEST_F(CalibrateTool, C10_bagsThatCannotBeUsedAreNamed) {
  const std::string bag = drive("a.bag", "fig4");
  EXPECT_THAT(calibrateBags({folder_.file("none.bag")}).error, HasSubstr("cannot be read"));
  EXPECT_THAT(calibrateBags({bag, "laser_pose:=other"}).error, HasSubstr("has no topic /other"));
  EXPECT_THAT(calibrateBags({bag, "wheel_ticks:=laser_pose"}).error,
              HasSubstr("is a geometry_msgs/PoseWithCovarianceStamped"));
  std::filesystem::resize_file(bag, std::filesystem::file_size(bag) / 2);
  const Outcome cut = calibrateBags({bag});
  EXPECT_EQ(cut.status, kInputErrorStatus);
  EXPECT_FALSE(written());
}

TEST_F(CalibrateTool, C10_posesThatNeverAgreeGiveNoBeginning) {
  rosbag::Bag bag(folder_.file("jump.bag"), rosbag::bagmode::Write);
  const rosbag::Bag in(drive("a.bag", "fig4"));
  double place = 0.0;
  for (const rosbag::MessageInstance& instance : rosbag::View(in)) {
    const auto pose = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>();
    if (!pose) {
      bag.write(instance.getTopic(), instance.getTime(), instance, instance.getConnectionHeader());
      continue;
    }
    geometry_msgs::PoseWithCovarianceStamped moved = *pose;
    moved.pose.pose.position.x = place += 10.0;
    bag.write(instance.getTopic(), instance.getTime(), moved);
  }
  bag.close();
  const Outcome outcome = calibrateBags({folder_.file("jump.bag"), "--no-refine"});
  EXPECT_NE(outcome.status, 0) << outcome.output;
  EXPECT_FALSE(written());
}

TEST_F(CalibrateTool, theReportIsReadableWithoutANetwork) {
  const std::string report = folder_.file("report");
  const Outcome outcome =
      calibrateBags({drive("a.bag", "fig4"), drive("b.bag", "slalom_eight"), "--report", report, "--pdf"});
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  for (const char* name : {"updates.csv", "paths.csv", "bound.csv", "summary.json"})
    EXPECT_GT(std::filesystem::file_size(report + "/" + name), 200u) << name;
  const std::string head = textOf(report + "/updates.csv").substr(0, 300);
  EXPECT_THAT(head, ::testing::StartsWith(
                        "stamp,distance,x,y,yaw,laser_x,laser_y,laser_yaw,innovation_x,innovation_y,"
                        "innovation_yaw,nis,weight,stage,k_d_front,k_d_front_std,k_d_rear,"
                        "k_d_rear_std,front/k_r,front/k_r_std,"));
  ASSERT_THAT(outcome.error, Not(HasSubstr("no figures"))) << "matplotlib, which the package depends on";
  const std::string page = textOf(report + "/index.html");
  EXPECT_THAT(page, HasSubstr("rear/k_b"));
  EXPECT_THAT(page, HasSubstr("checksum: "));
  EXPECT_THAT(page, Not(HasSubstr("http")));
  EXPECT_THAT(page, Not(HasSubstr("src=\"/")));
  std::size_t pictures = 0;
  for (std::size_t at = page.find("src=\""); at != std::string::npos; at = page.find("src=\"", at + 1)) {
    const std::string name = page.substr(at + 5, page.find('"', at + 5) - at - 5);
    EXPECT_TRUE(std::filesystem::exists(report + "/" + name)) << name;
    ++pictures;
  }
  EXPECT_GE(pictures, 7u);
  EXPECT_GT(std::filesystem::file_size(report + "/report.pdf"), 20000u);
}

TEST_F(CalibrateTool, aRefusedCalibrationHasAReportToo) {
  const std::string report = folder_.file("report");
  const Outcome outcome = calibrateBags({drive("s.bag", "straight"), "--report", report, "--no-refine"});
  EXPECT_EQ(outcome.status, kNotObservedStatus);
  EXPECT_THAT(textOf(report + "/summary.json"), HasSubstr("not observed yet: rear/k_b"));
}

/// The true scale of the steering sensor, 2.2, is beyond what the fit looks through, 0.5 to 2. The filter has
/// no such limit and observes every gain, so that no missing manoeuvre explains it.
TEST_F(CalibrateTool, aFitThatDoesNotConvergeIsStatus4) {
  const std::string bag = drive("a.bag", "fig4", {"--set", "steering/front/scale=2.2"});
  const Words options{bag, "--set", "calibration/estimate=[gains, steering_scale]", "--set",
                      "calibration/prior/steering_scale=1"};
  const Outcome outcome = calibrateBags(options);
  EXPECT_EQ(outcome.status, kNotConvergedStatus) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("the noise levels were not found: those configured hold"));
  EXPECT_THAT(outcome.error, HasSubstr("the fit of all readings at once did not converge"));
  EXPECT_THAT(outcome.error, HasSubstr("nothing was written"));
  EXPECT_FALSE(written());
}

/// The paper's method without a laser on its straight run: the tape says 20 m.
TEST_F(CalibrateTool, aTapeTakesTheLasersPlaceOnTheStraightRun) {
  const std::string straight = drive("straight.bag", "straight", {"--laser-rate", "0"});
  const Words options{"--distance", "20", "--no-refine", "--set", "calibration/method=paper"};
  Words both{straight, drive("b.bag", "fig4", {"--seed", "2"})};
  both.insert(both.end(), options.begin(), options.end());
  const Outcome outcome = calibrateBags(both);
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  expectTruth(result());
  EXPECT_EQ(result().data.bags, (Words{"straight.bag", "b.bag"}));
}

/// It gives the mean of k_r and k_l, (1.02 + 0.99)/2, and says that this is all.
TEST_F(CalibrateTool, aTapeAloneShowsTheDistanceGainAlone) {
  const Outcome outcome = calibrateBags({drive("straight.bag", "straight", {"--laser-rate", "0"}),
                                         "--distance", "20", "--set", "calibration/method=paper"});
  EXPECT_EQ(outcome.status, kNotObservedStatus);
  const std::string before = "k_d of the rear axle is ";
  const std::size_t at = outcome.error.find(before);
  ASSERT_NE(at, std::string::npos) << outcome.error;
  // Four standard deviations after 20 m (docs/calibration.md, 1).
  EXPECT_NEAR(std::stod(outcome.error.substr(at + before.size())), 1.005, 4.0 * 0.0009);
  EXPECT_THAT(outcome.error, HasSubstr("give bags with laser_pose after it; nothing was written"));
  EXPECT_FALSE(written());
}

/// The same messages; laser poses of `from` and later [s since the beginning] are those of a map that was
/// moved by 1 m and turned by 20 degrees about its origin.
void addJump(const std::string& from, const std::string& to, double time) {
  const rosbag::Bag in(from);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  rosbag::View view(in);
  const ros::Time jump = view.getBeginTime() + ros::Duration(time);
  const Pose2 moved{1.0, 0.0, 20.0 * M_PI / 180.0};
  for (const rosbag::MessageInstance& instance : view) {
    const auto message = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>();
    if (!message || instance.getTime() < jump) {
      out.write(instance.getTopic(), instance.getTime(), instance, instance.getConnectionHeader());
      continue;
    }
    geometry_msgs::PoseWithCovarianceStamped jumped = *message;
    geometry_msgs::Pose& pose = jumped.pose.pose;
    const Pose2 seen = moved * Pose2{pose.position.x, pose.position.y,
                                     2.0 * std::atan2(pose.orientation.z, pose.orientation.w)};
    pose.position.x = seen.x;
    pose.position.y = seen.y;
    pose.orientation.z = std::sin(0.5 * seen.yaw);
    pose.orientation.w = std::cos(0.5 * seen.yaw);
    out.write(instance.getTopic(), instance.getTime(), jumped);
  }
}

TEST_F(CalibrateTool, C4_aJumpOfTheLocaliserIsNamed) {
  const std::string bag = drive("a.bag", "slalom_eight");
  const Outcome quiet = calibrateBags({bag, "--no-refine"});
  EXPECT_THAT(quiet.error, Not(HasSubstr("jumped")));
  addJump(bag, folder_.file("jump.bag"), 30.0);
  const Outcome outcome = calibrateBags({folder_.file("jump.bag"), "--no-refine"});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("warning: jump.bag: the localiser jumped by "));
  EXPECT_THAT(outcome.error, HasSubstr(" 20 deg at stamp 1600000030."));
  EXPECT_THAT(outcome.error, HasSubstr("the pose is taken anew, the gains are kept"));
  EXPECT_EQ(outcome.error.find("jumped"), outcome.error.rfind("jumped")) << "one jump is one warning";
  expectTruth(result());
}

TEST_F(CalibrateTool, anEarlierCalibrationIsNotUsedAndThatIsSaid) {
  const std::string bag = drive("a.bag", "fig4");
  ASSERT_EQ(calibrateBags({bag, "--no-refine"}).status, 0);
  const CalibrationResult nominal = result();
  const std::string earlier = folder_.file("earlier.yaml");
  std::filesystem::rename(file_, earlier);
  const Outcome outcome = calibrateBags({bag, "--no-refine", "--set", "calibration_file=" + earlier});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("warning: calibration_file is not used: "));
  EXPECT_EQ(result().values, nominal.values);
}

TEST(ParameterTable, saysThatTheNoiseWasNotFound) {
  Findings findings;
  findings.noise.emplace();
  findings.noise->wheel = {0.005, std::nan(""), std::nan(""), true};
  const std::string table = parameterTable(findings);
  EXPECT_THAT(table, HasSubstr("noise "));
  EXPECT_THAT(table, HasSubstr("not found: what is configured holds"));
  EXPECT_THAT(table, Not(HasSubstr("nan")));
}

TEST_F(CalibrateTool, mistakesAreNamed) {
  const std::string bag = drive("a.bag", "fig4");
  EXPECT_THAT(calibrateBags({}).error, HasSubstr("'--input' is required"));
  EXPECT_THAT(calibrateBags({bag, "--pdf"}).error, HasSubstr("--pdf needs --report"));
  EXPECT_THAT(calibrateBags({bag, "--distance", "20"}).error, HasSubstr("calibration/method=paper"));
  EXPECT_THAT(calibrateBags({bag, "--report", bag}).error, HasSubstr("cannot make that folder"));
  EXPECT_THAT(calibrateBags({bag, "--set", "calibration/priors/k_r=1"}).error,
              HasSubstr("calibration/prior"));
  EXPECT_FALSE(written());
}

TEST_F(CalibrateTool, aBagIsNotOverwritten) {
  const std::string bag = drive("a.bag", "fig4");
  const auto size = std::filesystem::file_size(bag);
  const Words words{"calibrate_bag", bag, "--config", car_, "--output", bag};
  const auto arguments = pointers(words);
  EXPECT_THAT(errorOf([&] { calibrate(static_cast<int>(arguments.size()), arguments.data()); }),
              HasSubstr("must not be one of the bags"));
  EXPECT_EQ(std::filesystem::file_size(bag), size);
}

TEST(CalibrateToolDeathTest, helpIsStatusZero) {
  const Words words{"calibrate_bag", "--help"};
  const auto arguments = pointers(words);
  EXPECT_EXIT(calibrate(static_cast<int>(arguments.size()), arguments.data()), ::testing::ExitedWithCode(0),
              "");
}

TEST(RunTool, aNoResultErrorHasAStatusOfItsOwn) {
  captureStderr();
  EXPECT_EQ(runTool("tool", [] { throw NoResultError(kNotConvergedStatus, "no luck"); }), 4);
  EXPECT_EQ(GetCapturedStderr(), "tool: no luck\n");
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
