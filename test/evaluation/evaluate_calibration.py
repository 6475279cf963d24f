#!/usr/bin/python3
"""Gains fitted over recorded drives against the gains that the recordings' READMEs fit: one table of end drifts.

For every group of fitted_drift.yaml calibrate_bag runs over the group's drives, with the fit of all readings at once by
either objective and with the filter alone, and replay_bag over each of them with what was found. calibrate_bag itself
says the drift by the gains of all the other drives (leave one out), from the first to the last pose that it got. The
READMEs' gains are those of the least drift: the exit status is 1 where the drift with the gains of the objective
`path` is more than the README's plus 0.1 % of the distance. Without recordings: 77.
"""

import argparse
import csv
import pathlib
import re
import sys
from dataclasses import dataclass

import numpy as np
import yaml

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "scripts")]
import evaluate_recorded  # noqa: E402
import programs  # noqa: E402
import trajectory  # noqa: E402

# Of the distance, above the README's drift [%].
TOLERANCE = 0.1
# Ways of calibrating -> options of calibrate_bag.
OBJECTIVES = {"likelihood": ["--objective", "likelihood"], "path": ["--objective", "path"]}
WAYS = {**OBJECTIVES, "filter": ["--no-refine"]}
# Ratio of the right rear gain to the left one of car n008, by the README's fit.
REAR_RATIO = 0.9916 / 1.0105
RATIO_TOLERANCE = 0.001


@dataclass
class Drive:
    """One recorded drive as bags."""

    name: str
    bag: pathlib.Path               # all poses
    calibration_bag: pathlib.Path   # poses so far apart that their errors are independent
    truth: trajectory.Trajectory


@dataclass
class Parameter:
    """A row of calibrate_bag's table."""

    value: float
    deviation: float
    prior: float
    observed: bool


@dataclass
class Calibration:
    """What calibrate_bag has found over some drives."""

    path: pathlib.Path  # None: nothing was written
    said: str
    parameters: dict    # name -> Parameter

    def laser(self):
        """x [m], y [m], yaw [rad] of the laser in base_link."""
        written = (yaml.safe_load(self.path.read_text()).get("laser") or {}) if self.path else {}
        return np.array([written.get(name, 0.0) for name in ("x", "y", "yaw")])


@dataclass
class Row:
    """Drifts of a drive, or means of several [% of the distance]."""

    group: str
    axles: str
    runs: str
    baseline: float    # None: the README has none
    drifts: dict       # way of calibrating -> drift
    left_out: dict     # objective -> drift by the other drives' gains; nan: there is no other drive
    track_gain: Parameter

    def missed_by(self):
        """How much above what is allowed [% of the distance], to the README's digits; nan where nothing is stated."""
        return float("nan") if self.baseline is None else round(self.drifts["path"], 2) - self.baseline - TOLERANCE

    def holds(self):
        """Within the tolerance; True where nothing is stated."""
        return self.baseline is None or self.missed_by() < 1e-9

    def verdict(self):
        """For the table."""
        if self.baseline is None:
            return ""
        return "ok" if self.holds() else f"**MISSED** by {self.missed_by():.2f} %"


@dataclass
class Found:
    """What a group's axles come to: gains by each way of calibrating, and the rows of the table."""

    group: str
    axles: str
    calibrations: dict  # way of calibrating -> Calibration
    rows: list


def first_stamp(table):
    """Of the first row of a CSV [s]."""
    with open(table, newline="") as source:
        return float(list(csv.reader(source))[1][0])


def thin(poses, begin, interval, distance, output):
    """Writes the rows of a CSV of poses from `begin` on [s] that are at least `interval` [s] and `distance` [m] apart."""
    with open(poses, newline="") as source, open(output, "w", newline="") as target:
        reader, writer = csv.reader(source), csv.writer(target)
        writer.writerow(next(reader))
        last = np.full(3, -np.inf)
        for row in reader:
            here = np.array(row[:3], dtype=float)
            if here[0] >= begin and here[0] >= last[0] + interval and np.hypot(*(here - last)[1:]) >= distance:
                writer.writerow(row)
                last = here


def parameters_said(text):
    """Rows of calibrate_bag's table of parameters."""
    number = r"([-+.0-9enaif]+)"
    rows = re.findall(rf"^(\w+/\w+) +{number} +{number} +{number} +(yes|no)\b", text, re.MULTILINE)
    return {name: Parameter(float(value), float(deviation), float(prior), observed == "yes")
            for name, value, deviation, prior, observed in rows}


def drifts_left_out(text):
    """Name of each bag -> drift by the other bags' gains [% of the distance], from calibrate_bag's last table."""
    drift = r" +[-.\d]+ m \( *[-.\dnaif]+ %\)"
    rows = re.findall(rf"^(\S+) +[.\d]+ m{drift}{drift} +[-.\d]+ m \( *([.\d]+) %\)", text, re.MULTILINE)
    return {name: float(value) for name, value in rows}


def started_by_laser(odometry, laser, truth):
    """Errors of the laser's pose, when the car starts where the laser has seen it."""
    yaw = odometry.poses[:, 2]
    cos, sin = np.cos(yaw), np.sin(yaw)
    lever = np.column_stack([laser[0] * cos - laser[1] * sin, laser[0] * sin + laser[1] * cos,
                             np.full(len(yaw), laser[2])])
    seen = trajectory.Trajectory(odometry.stamps, odometry.poses + lever, odometry.covariances)
    return evaluate_recorded.errors_from_start(seen, truth)


class Group:
    """Drives of one car that are calibrated together."""

    def __init__(self, name, settings, data, tools, folder):
        recording = evaluate_recorded.load_yaml("recordings.yaml")[settings["recording"]]
        self._name = name
        self._settings = settings
        self._tools = tools
        self._folder = folder
        self._vehicle = HERE / recording["vehicle"]
        source = data / settings["recording"]
        runs = sorted({run for pattern in settings["runs"] for run in source.glob(pattern)})
        self._drives = [self._drive(run, recording["csv_to_bag"]) for run in runs]

    def evaluate(self, axles):
        """Every way of calibrating, and every drive with each of them."""
        calibrations = {way: self.calibrate(axles, way) for way in WAYS}
        left_out = {objective: drifts_left_out(calibrations[objective].said) for objective in OBJECTIVES}
        drifts = {drive.name: ([self._drift(drive, axles, calibration) for calibration in calibrations.values()],
                               [said.get(drive.calibration_bag.name, float("nan")) for said in left_out.values()])
                  for drive in self._drives}
        track_gain = calibrations["path"].parameters.get(f"{'rear' if axles == 'both' else axles}/k_b")
        rows = [self._row(axles, pattern, baseline, drifts, track_gain)
                for pattern, baseline in self._settings["baseline"][axles].items()]
        return Found(self._name, axles, calibrations, rows)

    def calibrate(self, axles, way):
        """calibrate_bag over the drives; gains that are not observed stay as they are."""
        output = self._folder / f"{axles}-{way}.yaml"
        settings = {"odometry/axles": axles, "calibration/allow_partial": "true",
                    "calibration/estimate": "[" + ", ".join(self._settings["estimate"][axles]) + "]",
                    **self._settings["settings"]}
        try:
            said = programs.run(self._tools, "calibrate_bag", *(drive.calibration_bag for drive in self._drives),
                                "--config", self._vehicle, "--output", output, *programs.settings(settings), *WAYS[way])
        except RuntimeError as error:  # not one gain was observed, or no fit: those of the vehicle hold
            return Calibration(None, str(error), parameters_said(str(error)))
        return Calibration(output, said, parameters_said(said))

    def _drive(self, run, arguments):
        bag = self._folder / f"{run.name}.bag"
        calibration_bag = self._folder / f"{run.name}.calibration.bag"
        poses = self._folder / f"{run.name}.pose.csv"
        # A pose before the wheels' first message cannot be used, and the next one would be a whole interval later.
        thin(run / "pose.csv", first_stamp(run / "wheels.csv"), self._settings["pose_interval"],
             self._settings.get("pose_distance", 0.0), poses)
        evaluate_recorded.convert(self._tools, run, arguments, bag)
        evaluate_recorded.convert(self._tools, run, arguments, calibration_bag, poses)
        return Drive(run.name, bag, calibration_bag, trajectory.read_odometry(str(bag), "ground_truth"))

    def _drift(self, drive, axles, calibration):
        arguments = ["--calibration", calibration.path] if calibration.path else []
        odometry = evaluate_recorded.replay(self._tools, drive.bag, self._vehicle, *arguments,
                                            *programs.settings({"odometry/axles": axles}))
        errors = started_by_laser(odometry, calibration.laser(), drive.truth)
        return evaluate_recorded.Run(drive.name, drive.truth, {axles: errors}).drift(axles)

    def _row(self, axles, pattern, baseline, drifts, track_gain):
        matching = [values for name, values in drifts.items() if pathlib.PurePath(name).match(pattern)]
        nothing = [([float("nan")] * len(WAYS), [float("nan")] * len(OBJECTIVES))]
        means, left_out = (np.mean(values, axis=0) for values in zip(*(matching or nothing)))
        return Row(self._name, axles, pattern, baseline, dict(zip(WAYS, means)), dict(zip(OBJECTIVES, left_out)),
                   track_gain)


def evaluate(data, tools, folder, names=None):
    """Every group, or those named, with each of its axles."""
    found = []
    for name, settings in evaluate_recorded.load_yaml("fitted_drift.yaml").items():
        if names and name not in names:
            continue
        place = folder / name
        place.mkdir(parents=True, exist_ok=True)
        group = Group(name, settings, data, tools, place)
        found += [group.evaluate(axles) for axles in settings["baseline"]]
    return found


def rear_ratio(calibration):
    """k_r / k_l of the rear axle."""
    return calibration.parameters["rear/k_r"].value / calibration.parameters["rear/k_l"].value


def percent(value):
    """A drift for the table."""
    return "" if value is None or np.isnan(value) else f"{value:.2f} %"


def gain_cell(parameter):
    """Value, deviation, and whether it was observed."""
    if parameter is None:
        return ""
    return f"{parameter.value:.4f} ± {parameter.deviation:.4f}" + ("" if parameter.observed else ", not observed")


def table_of_rows(rows):
    """Markdown: drift of every row."""
    lines = ["| runs | axles | README | path | likelihood | filter | left out: path | likelihood | | k_b |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        drifts = [row.baseline, *(row.drifts[way] for way in ("path", "likelihood", "filter")),
                  *(row.left_out[objective] for objective in ("path", "likelihood"))]
        cells = [f"{row.group}: {row.runs}", row.axles, *map(percent, drifts), row.verdict(), gain_cell(row.track_gain)]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def table_of_parameters(found):
    """Markdown: what was found over each group."""
    lines = ["| runs | axles | parameter | path | likelihood | filter |", "|---|---|---|---|---|---|"]
    for one in found:
        for name in one.calibrations["likelihood"].parameters:
            cells = [gain_cell(one.calibrations[way].parameters.get(name)) for way in ("path", "likelihood", "filter")]
            lines.append(f"| {one.group} | {one.axles} | {name} | {' | '.join(cells)} |")
    return lines


def report(found, output):
    """Prints the tables and writes them to the output folder; True when everything holds."""
    rows = [row for one in found for row in one.rows]
    ratio = rear_ratio(next(one.calibrations["path"] for one in found if (one.group, one.axles) == ("n008", "rear")))
    ratio_holds = abs(ratio / REAR_RATIO - 1.0) <= RATIO_TOLERANCE
    stated = [row for row in rows if row.baseline is not None]
    holding = sum(row.holds() for row in stated)
    lines = ["# Gains fitted over recorded drives", "", "End drift in % of the distance.", "", *table_of_rows(rows), "",
             f"Rear gains of n008, right over left: {ratio:.5f}, README {REAR_RATIO:.5f}: "
             f"{'ok' if ratio_holds else '**MISSED**'}.", "",
             f"{holding} of {len(stated)} drifts are at most the README's plus {TOLERANCE} % of the distance.", "",
             "## Parameters", "", *table_of_parameters(found)]
    print("\n".join(lines))
    (output / "calibration.md").write_text("\n".join(lines) + "\n")
    return ratio_holds and holding == len(stated)


def parse_arguments(description):
    """The command line."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=evaluate_recorded.default_data_folder(),
                        help="default: %(default)s")
    parser.add_argument("--tools", type=pathlib.Path, required=True,
                        help="folder of csv_to_bag, calibrate_bag and replay_bag")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="folder for the table")
    parser.add_argument("--no-plots", action="store_true", help="there are none: taken for evaluate_recorded.py's sake")
    return parser.parse_args()


def run(description, name, evaluate_all, report_all):
    """Evaluates with bags in a folder of that name, reports; the exit status says whether everything holds."""
    arguments = parse_arguments(description)
    if not arguments.data.is_dir():
        print(f"No recordings: {arguments.data} is not there (BS_CAR_ODOMETRY_DATA names another folder).")
        return evaluate_recorded.SKIPPED
    bags = arguments.output / name
    bags.mkdir(parents=True, exist_ok=True)
    return 0 if report_all(evaluate_all(arguments.data, arguments.tools, bags), arguments.output) else 1


if __name__ == "__main__":
    sys.exit(run(__doc__, "calibration", evaluate, report))
