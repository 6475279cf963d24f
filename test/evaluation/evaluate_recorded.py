#!/usr/bin/python3
"""Odometry over recorded drives with the nominal geometry: one table of all runs, and paths over the truth.

Every run goes through csv_to_bag and replay_bag: one axle with equation (2) as printed and with the exact arc,
and both axles. Where the recordings' README gives the drift of equation (2), the table says whether ours is
within 15 % of it or 0.2 % of the distance; the exit status is 1 when one is not. Without recordings: 77.
"""

import argparse
import concurrent.futures
import os
import pathlib
import sys
from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend has to be chosen first)
import numpy as np  # noqa: E402
import yaml  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
import programs  # noqa: E402
import trajectory  # noqa: E402

SKIPPED = 77
# Agreement with the README's figure: of its value, or in % of the distance.
RELATIVE_TOLERANCE = 0.15
ABSOLUTE_TOLERANCE = 0.2
# Runs that hardly leave the spot [m].
SHORT = 1.5


@dataclass
class Run:
    """One recorded drive and the path of each method over it, each started at the first true pose."""

    name: str   # set/run
    truth: trajectory.Trajectory
    errors: dict  # method -> trajectory.Errors

    def drift(self, method):
        """End drift in % of the distance driven."""
        return 100.0 * self.errors[method].end_drift() / self.distance()

    def distance(self):
        """Length of the true path [m]; every tenth pose, since the noise of each would add up."""
        poses = self.truth.poses[::10]
        return trajectory.Trajectory(self.truth.stamps[::10], poses, self.truth.covariances[::10]).distance()


@dataclass
class Check:
    """A figure of the README against ours."""

    runs: str
    method: str
    stated: float    # % of the distance
    measured: float  # % of the distance

    def holds(self):
        """Within the tolerance."""
        difference = abs(self.measured - self.stated)
        return difference <= max(RELATIVE_TOLERANCE * self.stated, ABSOLUTE_TOLERANCE)


def default_data_folder():
    """$BS_CAR_ODOMETRY_DATA, or a folder beside the checkout."""
    return pathlib.Path(os.environ.get("BS_CAR_ODOMETRY_DATA") or ROOT.parent / "shared/data")


def methods_of(axles):
    """Name of each method -> settings of replay_bag."""
    methods = {}
    for axle in axles:
        methods[f"{axle}, exact"] = {"odometry/axles": axle, "odometry/motion": "exact"}
        if axle != "both":
            methods[f"{axle}, (2)"] = {"odometry/axles": axle, "odometry/motion": "paper"}
    return methods


def load_yaml(name):
    """A file of this folder."""
    return yaml.safe_load((HERE / name).read_text())


def convert(tools, folder, arguments, bag, pose=None):
    """A bag from a run's CSV files, with the poses of another file if one is given."""
    steering = folder / "steering.csv"
    programs.run(tools, "csv_to_bag", "--wheels", folder / "wheels.csv", "--pose", pose or folder / "pose.csv",
                 *arguments, *(["--steering", steering] if steering.exists() else []), "--output", bag)


def replay(tools, bag, vehicle, *arguments):
    """The odometry over a bag."""
    output = bag.with_suffix(".odometry.bag")
    programs.run(tools, "replay_bag", bag, "--config", vehicle, "--output", output, *arguments)
    odometry = trajectory.read_odometry(str(output), "odom")
    output.unlink()
    return odometry


def errors_from_start(odometry, truth):
    """Errors while there is truth, the path put on the first true pose."""
    shared = odometry.between(truth.stamps[0], truth.stamps[-1])
    return trajectory.compare(shared.started_at(truth.at(shared.stamps[:1])[0]), truth)


class Evaluation:
    """Runs the tools, with bags in a folder of its own."""

    def __init__(self, data, tools, bags):
        self._data = data
        self._tools = tools
        self._bags = bags
        self._recordings = load_yaml("recordings.yaml")

    def run_all(self):
        """Every run of every set, several at a time."""
        jobs = [(name, folder) for name in self._recordings for folder in sorted((self._data / name).iterdir())
                if (folder / "wheels.csv").exists()]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            return list(pool.map(lambda job: self._run(*job), jobs))

    def _run(self, recording, folder):
        settings = self._recordings[recording]
        bag = self._bags / f"{recording}-{folder.name}.bag"
        convert(self._tools, folder, settings["csv_to_bag"], bag)
        truth = trajectory.read_odometry(str(bag), "ground_truth")
        errors = {method: self._replay(bag, HERE / settings["vehicle"], overrides, truth)
                  for method, overrides in methods_of(settings["axles"]).items()}
        return Run(f"{recording}/{folder.name}", truth, errors)

    def _replay(self, bag, vehicle, settings, truth):
        return errors_from_start(replay(self._tools, bag, vehicle, *programs.settings(settings)), truth)


def checks(runs):
    """Every figure that the READMEs give."""
    found = []
    for row in load_yaml("nominal_drift.yaml"):
        method = f"{row['axle']}, (2)"
        drifts = [run.drift(method) for run in runs if pathlib.PurePath(run.name).match(row["runs"])]
        found.append(Check(row["runs"], method, row["drift"], float(np.mean(drifts)) if drifts else float("nan")))
    return found


def cell(run, method):
    """Drift and heading error; a drift in % of next to nothing would say nothing."""
    errors = run.errors[method]
    short = run.distance() < SHORT
    drift = f"{1000.0 * errors.end_drift():.0f} mm" if short else f"{run.drift(method):.2f} %"
    return f"{drift}, {np.degrees(errors.end_yaw()):+.1f}°"


def table_of_runs(runs):
    """Markdown: end drift and heading error of every run by every method."""
    methods = list(methods_of(["front", "rear", "both"]))
    lines = ["| run | distance | " + " | ".join(methods) + " |", "|---|---|" + "---|" * len(methods)]
    for run in runs:
        cells = [cell(run, method) if method in run.errors else "" for method in methods]
        lines.append(f"| {run.name} | {run.distance():.1f} m | " + " | ".join(cells) + " |")
    return lines


def table_of_checks(found):
    """Markdown: the READMEs' figures against ours."""
    lines = ["| runs | method | README | measured | |", "|---|---|---|---|---|"]
    return lines + [f"| {check.runs} | {check.method} | {check.stated:g} % | {check.measured:.2f} % | "
                    f"{'holds' if check.holds() else '**differs**'} |" for check in found]


def draw(run, path):
    """The paths of all methods over the truth."""
    figure, axes = plt.subplots(figsize=(8, 7))
    axes.plot(*run.truth.poses[:, :2].T, color="black", linewidth=4, alpha=0.3, label="truth")
    for method, errors in run.errors.items():
        axes.plot(*errors.estimate.poses[:, :2].T, linewidth=1.2, label=f"{method}: {run.drift(method):.2f} %")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title=run.name, xlabel="x [m]", ylabel="y [m]")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=90)
    plt.close(figure)


def report(runs, found, output, with_plots):
    """Prints the tables and writes them, with the plots, to the output folder."""
    lines = ["# Recorded drives, nominal geometry", "", "End drift in % of the distance (in mm where the car hardly left the spot), heading error at the end.",
             "", *table_of_runs(runs), "", "## Against the recordings' own figures", "", *table_of_checks(found)]
    print("\n".join(lines))
    (output / "recorded.md").write_text("\n".join(lines) + "\n")
    for run in runs if with_plots else []:
        draw(run, output / (run.name.replace("/", "-") + ".png"))


def parse_arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=default_data_folder(), help="default: %(default)s")
    parser.add_argument("--tools", type=pathlib.Path, required=True, help="folder of csv_to_bag and replay_bag")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="folder for the table and the plots")
    parser.add_argument("--no-plots", action="store_true")
    return parser.parse_args()


def main():
    """Evaluates, reports, and says how many figures hold."""
    arguments = parse_arguments()
    if not arguments.data.is_dir():
        print(f"No recordings: {arguments.data} is not there (BS_CAR_ODOMETRY_DATA names another folder).")
        return SKIPPED
    bags = arguments.output / "bags"
    bags.mkdir(parents=True, exist_ok=True)
    runs = Evaluation(arguments.data, arguments.tools, bags).run_all()
    found = checks(runs)
    report(runs, found, arguments.output, not arguments.no_plots)
    holding = sum(check.holds() for check in found)
    print(f"\n{holding} of {len(found)} figures of the recordings' READMEs hold.")
    return 0 if holding == len(found) else 1


if __name__ == "__main__":
    sys.exit(main())
