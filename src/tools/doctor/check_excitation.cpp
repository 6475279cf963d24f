#include "checks.hpp"

#include "bs_car_odometry/calibration/observability.hpp"

#include <cmath>
#include <string>

namespace bs_car_odometry::tools::doctor {

namespace {

using calibration::Knowledge;

constexpr double kDegrees = 180.0 / M_PI;

Finding parameterFinding(const Knowledge& knowledge, std::size_t parameter) {
  const auto i = static_cast<Eigen::Index>(parameter);
  const std::string figures =
      format("%s: standard deviation %.4g before, %.2g after this drive",
             calibration::parameterName(parameter).c_str(), knowledge.prior[i], knowledge.deviation[i]);
  if (knowledge.observed(parameter)) return fine(figures + ", observed");
  return warning(figures + ", not observed", "");
}

}  // namespace

Findings checkExcitation(const CalibrationAdapter& adapter) {
  const Knowledge knowledge = calibration::knowledgeOf(adapter.calibrator());
  const calibration::Excitation& drive = knowledge.excitation;
  Findings findings;
  const std::string missing = calibration::missing(knowledge);
  if (!missing.empty()) findings.push_back(warning("the drive does not show every parameter", missing));
  findings.push_back(
      fine(format("drive: %.1f m, %.1f m of it straight, %.0f deg left, %.0f deg right", drive.distance,
                  drive.straight, drive.turned_left * kDegrees, drive.turned_right * kDegrees)));
  for (std::size_t i = 0; i < calibration::kCount; ++i)
    if (knowledge.estimated[i]) findings.push_back(parameterFinding(knowledge, i));
  return findings;
}

}  // namespace bs_car_odometry::tools::doctor
