// What a wrong model costs: the table of docs/model.md, section 3.4, rear axle. Simulator and odometry share
// no equation, so these drives show that the one finds mistakes in the other.
#include "cars.hpp"
#include "drive.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace bs_car_odometry::drives {
namespace {

/// Odometry models of the table's columns.
OdometryConfiguration exactModel(AxleGeometry geometry) {
  return odometryOf(cycab(geometry), AxleSelection::kRear);
}
OdometryConfiguration papersModel() {
  OdometryConfiguration configuration = exactModel(AxleGeometry::kPivot);
  configuration.options.motion = Motion::kPaper;
  return configuration;
}
OdometryConfiguration unshortenedModel() {
  OdometryConfiguration configuration = papersModel();
  configuration.options.shortened_track = false;
  return configuration;
}

/// Largest distance from the exact path [m], as the table has it.
struct Row {
  AxleGeometry wheels;
  const char* run;
  double paper;        ///< (M-1), model A
  double unshortened;  ///< (M-1), B for B cos(alpha)
  double pivot;        ///< (M-arc), model A
  double ackermann;    ///< (M-arc), model B
};
constexpr AxleGeometry kAckermann = AxleGeometry::kAckermann;
constexpr AxleGeometry kPivot = AxleGeometry::kPivot;
constexpr Row kTable[] = {
    {kAckermann, "fig4", 0.036, 0.52, 0.040, 0.00011},
    {kAckermann, "slalom_eight", 1.38, 11.9, 1.38, 0.00035},
    {kAckermann, "circle", 0.266, 2.83, 0.266, 0.0},
    {kPivot, "fig4", 0.0052, 0.48, 0.00011, 0.040},
    {kPivot, "slalom_eight", 0.023, 10.6, 0.00033, 1.46},
    {kPivot, "circle", 0.0004, 2.62, 0.0, 0.270},
};

std::vector<Sample> recordRun(const std::string& run, AxleGeometry wheels) {
  DriveSettings settings;
  settings.scenario = run;
  settings.rate = run == "circle" ? 20.0 : 50.0;
  if (run == "slalom_eight") settings.speed_factor = 2.0;
  if (run == "slalom_eight") settings.duration = 59.8;
  if (run == "circle") settings.duration = 30.1;
  return record(cycab(wheels), settings);
}

double largest(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  return departure(configuration, drive).largest;
}

/// The table gives two or three digits; a 0 stands for what only the rounding of the counters leaves.
void expectTabled(double measured, double tabled, const char* model) {
  SCOPED_TRACE(model);
  if (tabled == 0.0)
    EXPECT_LT(measured, 1e-5);
  else
    EXPECT_NEAR(measured, tabled, 0.06 * tabled);
}

TEST(WrongModel, costsWhatTheTableSays) {
  for (const Row& row : kTable) {
    SCOPED_TRACE(std::string(name(row.wheels)) + " wheels, " + row.run);
    const std::vector<Sample> drive = recordRun(row.run, row.wheels);
    expectTabled(largest(papersModel(), drive), row.paper, "(M-1), model A");
    expectTabled(largest(unshortenedModel(), drive), row.unshortened, "(M-1), B for B cos(alpha)");
    expectTabled(largest(exactModel(kPivot), drive), row.pivot, "(M-arc), model A");
    expectTabled(largest(exactModel(kAckermann), drive), row.ackermann, "(M-arc), model B");
  }
}

/// Decimetres for the other axle model, ten times as much without cos(alpha): all four wheels, 60 m at 20 Hz.
TEST(WrongModel, otherAxleModelEndsDecimetresAwayWithAllWheels) {
  DriveSettings settings;
  settings.scenario = "slalom_eight";
  const std::vector<Sample> drive = record(cycab(kPivot), settings);
  const double right = departure(odometryOf(cycab(kPivot), AxleSelection::kBoth), drive).at_end;
  const double wrong = departure(odometryOf(cycab(kAckermann), AxleSelection::kBoth), drive).at_end;
  std::printf("right model: %.4f m, wrong model: %.4f m\n", right, wrong);
  EXPECT_LT(right, 5e-3);
  EXPECT_GT(wrong, 0.1);
}

}  // namespace
}  // namespace bs_car_odometry::drives
