#include "simulated_consistency.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/laboratory/consistency.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/simulation/scenario.hpp"
#include "consistency_table.hpp"
#include "program.hpp"
#include "tool.hpp"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry::tools {

namespace {

namespace po = boost::program_options;

using Words = std::vector<std::string>;

struct Request {
  std::string config;
  Words settings;
  std::string scenario;
  std::string method;  ///< empty: the vehicle file's, likewise the next two
  std::string axles;
  std::string geometry;
  std::size_t runs{1000};
  std::uint64_t seed{1};
  double rate{50.0};
  double substep{0.01};
  std::size_t places{10};
  unsigned threads{0};
  bool draw_gains{false};
  bool no_draw_gains{false};
  std::string csv;
  std::string picture;
};

po::options_description optionsFor(Request& request) {
  po::options_description options("options (NAMES: one, several with commas between them, or 'all')");
  auto add = options.add_options();
  add("scenario", po::value(&request.scenario)->required(), "NAMES; 'all' leaves out those with faults");
  add("config", po::value(&request.config)->required(), "vehicle file");
  add("set", po::value(&request.settings)->composing(), "parameter=value, instead of the vehicle file's");
  add("method", po::value(&request.method), "NAMES of odometry/uncertainty");
  add("axles", po::value(&request.axles), "NAMES of odometry/axles");
  add("geometry", po::value(&request.geometry), "NAMES of vehicle/axle_geometry");
  add("runs", po::value(&request.runs)->default_value(request.runs), "drives of each scenario");
  add("seed", po::value(&request.seed)->default_value(request.seed), "of the first drive; each has the next");
  add("rate", po::value(&request.rate)->default_value(request.rate), "messages [Hz]");
  add("substep", po::value(&request.substep)->default_value(request.substep, "0.01"),
      "of the simulation [s]");
  add("places", po::value(&request.places)->default_value(request.places),
      "judged along each drive, at equal distances");
  add("draw-gains", po::bool_switch(&request.draw_gains),
      "true parameters drawn from noise/systematic (the default)");
  add("no-draw-gains", po::bool_switch(&request.no_draw_gains), "true parameters as configured");
  add("threads", po::value(&request.threads)->default_value(0), "0: one for each processor");
  add("csv", po::value(&request.csv), "write every place along the drives here");
  add("picture", po::value(&request.picture), "draw them, as PNG");
  return options;
}

void checkRanges(const Request& request) {
  const auto check = [](bool holds, const std::string& rule) {
    if (!holds) throw InputError(rule);
  };
  check(request.runs >= 2 && request.runs <= 10000000, "--runs must be from 2 to 10000000");
  check(request.rate > 0.0 && request.rate <= 1000.0, "--rate must be above 0, at most 1000 Hz");
  check(request.substep >= 1e-4 && request.substep <= 0.1, "--substep must be from 0.0001 to 0.1 s");
  check(request.places >= 1 && request.places <= 1000, "--places must be from 1 to 1000");
  check(request.threads <= 1024, "--threads must be at most 1024");
  check(!(request.draw_gains && request.no_draw_gains),
        "--draw-gains and --no-draw-gains exclude each other");
}

Request parse(int argc, const char* const* argv) {
  Request request;
  const std::string usage =
      "consistency --scenario NAMES --config VEHICLE.yaml [options]\n\n"
      "Published covariances against the truth of many simulated drives, from a known start: mean NEES of\n"
      "pose and twist, and how many true poses lie within 1, 2 and 3 sigma. One line for each scenario, "
      "axle\n"
      "geometry, choice of axles and method; all odometries of a scenario read the same drives.\n"
      "Over recorded drives: consistency --recorded FOLDER --help.\n\n"
      "scenarios:\n" +
      simulation::scenarioDescriptions();
  parseCommandLine(argc, argv, usage, optionsFor(request));
  checkRanges(request);
  return request;
}

/// The words of "a,b"; `all` for "all", `fallback` for nothing.
Words wordsOf(const std::string& text, const Words& all, const Words& fallback) {
  if (text.empty()) return fallback;
  if (text == "all") return all;
  Words words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

/// A parameter that takes one word out of several, and the words to go through.
struct Choice {
  Choice(std::string parameter_path, const std::string& names, const Parameters& configured)
      : path(std::move(parameter_path)),
        words(wordsOf(names, parameterWords(path), {parameterWord(configured, path)})) {}

  std::string setting(const std::string& word) const { return path + "=" + word; }

  std::string path;
  Words words;
};

struct Choices {
  Choice geometry;
  Choice axles;
  Choice method;
};

/// One line of the table for each scenario.
struct Odometry {
  std::string axles;
  std::string method;
  OdometryConfiguration configuration;
};

/// All that read the same drives.
std::vector<Odometry> odometriesOf(const Request& request, const Choices& choices,
                                   const std::string& geometry) {
  std::vector<Odometry> odometries;
  for (const std::string& axles : choices.axles.words)
    for (const std::string& method : choices.method.words) {
      Words settings = request.settings;
      settings.push_back(choices.geometry.setting(geometry));
      settings.push_back(choices.axles.setting(axles));
      settings.push_back(choices.method.setting(method));
      OdometryConfiguration configuration =
          toConfiguration(readVehicle({request.config}, settings).parameters);
      configuration.initial_pose = InitialPose();
      odometries.push_back({axles, method, configuration});
    }
  return odometries;
}

bool hasFaults(const simulation::Scenario& scenario) { return !scenario.wheel_spins.empty(); }

/// The scenarios asked for; "all" are those without faults.
/// @throws simulation::ScenarioError for one that is not known
Words scenariosOf(const Request& request, const OdometryConfiguration& configuration) {
  const Vehicle& vehicle = configuration.vehicle;
  const simulation::Drivetrain drivetrain = simulation::drivetrainOf(vehicle, configuration.options.axles);
  const bool all = request.scenario == "all";
  Words names;
  for (const std::string& name : wordsOf(request.scenario, simulation::scenarioNames(), {}))
    if (!hasFaults(simulation::makeScenario(name, vehicle, drivetrain)) || !all) names.push_back(name);
  return names;
}

laboratory::StudySettings studyOf(const Request& request, const std::string& scenario,
                                  const std::vector<Odometry>& odometries) {
  const OdometryConfiguration& first = odometries.front().configuration;
  laboratory::StudySettings study;
  study.drive.scenario = scenario;
  study.drive.rate = request.rate;
  study.drive.substep = request.substep;
  study.drive.seed = request.seed;
  study.drive.axles = first.options.axles;
  study.drive.noise = first.noise;
  if (!request.no_draw_gains) study.drive.draw_gains = first.noise.systematic;
  study.drives = request.runs;
  study.places = request.places;
  study.threads = request.threads;
  for (const Odometry& odometry : odometries) study.odometries.push_back(odometry.configuration);
  return study;
}

/// Every scenario with every axle geometry; each line goes to the table as soon as it is known.
class Laboratory {
 public:
  Laboratory(const Request& request, const Choices& choices) : request_(request), choices_(choices) {
    for (const std::string& geometry : choices_.geometry.words)
      fleets_.push_back(odometriesOf(request_, choices_, geometry));
    scenarios_ = scenariosOf(request_, fleets_.front().front().configuration);
  }

  void run(std::ostream& csv) {
    Progress progress("consistency", static_cast<double>(scenarios_.size() * fleets_.size() * request_.runs));
    writeTableHead(std::cout, request_.runs);
    writeCsvHead(csv);
    double before = 0.0;
    for (const std::string& scenario : scenarios_)
      for (std::size_t g = 0; g < fleets_.size(); ++g) {
        laboratory::StudySettings study = studyOf(request_, scenario, fleets_[g]);
        study.progress = [&](std::size_t drives) { progress.update(before + static_cast<double>(drives)); };
        const auto results = laboratory::studyConsistency(study);
        progress.hide();
        write(scenario, g, results, csv);
        before += static_cast<double>(request_.runs);
      }
  }

 private:
  void write(const std::string& scenario, std::size_t g,
             const std::vector<laboratory::ConsistencyOverDistance>& results, std::ostream& csv) const {
    for (std::size_t k = 0; k < results.size(); ++k) {
      const Odometry& odometry = fleets_[g][k];
      const ConsistencyRow row{scenario, choices_.geometry.words[g], odometry.axles, odometry.method,
                               results[k]};
      writeTableRow(std::cout, row);
      writeCsvRows(csv, row);
    }
  }

  const Request& request_;
  const Choices& choices_;
  std::vector<std::vector<Odometry>> fleets_;  ///< one for each axle geometry
  Words scenarios_;
};

/// The files asked for, opened before the drives begin: a folder that is missing should not cost an hour.
class Files {
 public:
  explicit Files(const Request& request) : csv_path_(request.csv) {
    if (!request.picture.empty()) picture_.emplace(request.picture);
    const bool keep = !request.csv.empty();
    // A picture alone has a table too, beside it while it is drawn.
    if (keep || picture_) table_.emplace(keep ? request.csv : request.picture + ".csv");
  }

  void write(const std::string& csv) {
    if (!table_) return;
    std::ofstream file(table_->temporaryPath());
    file << csv;
    file.close();
    if (!file) throw InputError("cannot write " + table_->temporaryPath());
    std::string table = table_->temporaryPath();
    if (!csv_path_.empty()) {  // first: it stays when there is nothing to draw with
      table_->commit();
      table = csv_path_;
    }
    if (!picture_) return;
    runProgram({besideThisProgram("plot_consistency"), table, "--output", picture_->temporaryPath()});
    picture_->commit();
  }

 private:
  std::string csv_path_;
  std::optional<calibration::AtomicFile> table_;
  std::optional<calibration::AtomicFile> picture_;
};

}  // namespace

void consistency(int argc, const char* const* argv) {
  const Request request = parse(argc, argv);
  const Parameters configured = loadVehicle({request.config}, request.settings);
  const Choices choices{{"vehicle/axle_geometry", request.geometry, configured},
                        {"odometry/axles", request.axles, configured},
                        {"odometry/uncertainty", request.method, configured}};
  Laboratory laboratory(request, choices);
  Files files(request);
  std::ostringstream csv;
  laboratory.run(csv);
  files.write(csv.str());
}

}  // namespace bs_car_odometry::tools
