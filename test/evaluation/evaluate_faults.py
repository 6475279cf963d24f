#!/usr/bin/python3
"""Recorded drives of four-wheel cars with one wheel's readings spoilt half way: is it named, what does it cost?

Gains of both axles are fitted over each car's drives as they are. Then one column of the wheels is spoilt from the
middle of its way on, and replay_bag runs with those gains. Named: left out longer than any other sensor, and for most of
the second half where the fault lasts; a frozen speed is right as long as the car keeps it. The drift may be twice the untouched drive's, or 0.5 % of the distance more. Without recordings: 77.
"""

import csv
import pathlib
import sys
from dataclasses import dataclass

import numpy as np
import rosbag

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "scripts")]
import evaluate_calibration  # noqa: E402
import evaluate_recorded  # noqa: E402
import programs  # noqa: E402
import trajectory  # noqa: E402

GROUPS = ["n008", "n015", "comma"]
WHEELS = ["fl", "fr", "rl", "rr"]
SENSORS = WHEELS + ["front steering", "rear steering"]
FAULT_NAMES = ["", "undecided", "stuck", "reversed", "wrong travel", "swapped", "wrong angle", "frozen"]
# Of the untouched drive's drift, or in % of the distance more.
FACTOR = 2.0
MARGIN = 0.5


def spikes(speeds):
    """Every fiftieth reading ten times too large."""
    spoilt = speeds.copy()
    spoilt[::50] *= 10.0
    return spoilt


# Second half of a column of speeds -> what is read instead.
FAULTS = {
    "stuck at zero": np.zeros_like,
    "frozen": lambda speeds: np.full_like(speeds, speeds[0]),
    "spiked": spikes,
    "negated": lambda speeds: -speeds,
    "scaled by 1.1": lambda speeds: 1.1 * speeds,
}


@dataclass
class Row:
    """One drive with one fault."""

    drive: str
    wheel: str
    fault: str
    drift: float      # % of the distance
    untouched: float  # % of the distance
    shares: np.ndarray  # of the second half in which each sensor is left out
    said: str

    def names(self):
        """The wheel is left out most, and for a fault that lasts most of the time."""
        mine = WHEELS.index(self.wheel)
        lasts = self.fault not in ("spiked", "frozen")
        return self.shares[mine] == self.shares.max() and self.shares[mine] > (0.5 if lasts else 0.0)

    def bears(self):
        """The drift is within what is allowed."""
        return self.drift <= max(FACTOR * self.untouched, self.untouched + MARGIN)


def spoil(source, column, fault, target):
    """Writes the CSV of the wheels with one column spoilt from its middle on."""
    with open(source, newline="") as file:
        rows = list(csv.reader(file))
    speeds = np.array([row[1:5] for row in rows[1:]], dtype=float)
    way = np.cumsum(np.abs(speeds).sum(axis=1))
    half = int(np.searchsorted(way, 0.5 * way[-1]))
    values = speeds[:, column - 1].copy()
    values[half:] = FAULTS[fault](values[half:])
    for row, value in zip(rows[1:], values):
        row[column] = f"{value:.6f}"
    with open(target, "w", newline="") as file:
        csv.writer(file).writerows(rows)


def left_out(bag):
    """Share of the second half of the way in which each sensor is left out, and what is said of it most."""
    faults, distances = [], []
    with rosbag.Bag(str(bag)) as statuses:
        for _, message, _ in statuses.read_messages(topics=["odometry_status"]):
            faults.append([int(fault) for fault in list(message.wheel_fault) + list(message.steering_fault)])
            distances.append(message.distance)
    second = np.array(faults)[np.searchsorted(distances, 0.5 * distances[-1]):]
    shares = (second != 0).mean(axis=0)
    said = []
    for i, share in enumerate(shares):
        if share > 0.0:
            kind = np.bincount(second[second[:, i] != 0, i]).argmax()
            said.append(f"{SENSORS[i]} {FAULT_NAMES[kind]} {100.0 * share:.0f} %")
    return shares, ", ".join(said)


class Car:
    """The drives of a group, with gains of both axles fitted over them."""

    def __init__(self, name, data, tools, folder):
        described = evaluate_recorded.load_yaml("fitted_drift.yaml")[name]
        recording = evaluate_recorded.load_yaml("recordings.yaml")[described["recording"]]
        self._tools = tools
        self._folder = folder
        self._convert = recording["csv_to_bag"]
        self._vehicle = HERE / recording["vehicle"]
        self._settings = {"noise/wheel": described["settings"]["noise/wheel"]}
        self._calibration = evaluate_calibration.Group(name, described, data, tools, folder).calibrate("both", "path")
        self.runs = [data / described["recording"] / run for run in described["runs"]]

    def drive(self, run, wheels=None):
        """Drift [% of the distance], shares, and what is said, with a CSV of wheels in the place of the run's."""
        spoilt = self._folder / f"{run.name}-spoilt"
        spoilt.mkdir(exist_ok=True)
        for name in ("wheels.csv", "steering.csv", "pose.csv"):
            (spoilt / name).write_bytes((wheels if wheels and name == "wheels.csv" else run / name).read_bytes())
        bag = self._folder / f"{run.name}-spoilt.bag"
        evaluate_recorded.convert(self._tools, spoilt, self._convert, bag)
        output = bag.with_suffix(".odometry.bag")
        programs.run(self._tools, "replay_bag", bag, "--config", self._vehicle, "--output", output, "--calibration",
                     self._calibration.path, *programs.settings(self._settings))
        truth = trajectory.read_odometry(str(bag), "ground_truth")
        errors = evaluate_calibration.started_by_laser(trajectory.read_odometry(str(output), "odom"),
                                                       self._calibration.laser(), truth)
        return evaluate_recorded.Run(run.name, truth, {"both": errors}).drift("both"), *left_out(output)

    def rows(self):
        """Every drive untouched, and with every fault of every wheel."""
        for run in self.runs:
            untouched, shares, said = self.drive(run)
            yield Row(run.name, "", "", untouched, untouched, shares, said)
            for column, wheel in enumerate(WHEELS, start=1):
                for fault in FAULTS:
                    wheels = self._folder / "wheels.csv"
                    spoil(run / "wheels.csv", column, fault, wheels)
                    drift, shares, said = self.drive(run, wheels)
                    yield Row(run.name, wheel, fault, drift, untouched, shares, said)


def evaluate(data, tools, folder, names=None):
    """Rows of every car."""
    rows = []
    for name in names or GROUPS:
        place = folder / name
        place.mkdir(parents=True, exist_ok=True)
        rows += Car(name, data, tools, place).rows()
    return rows


def report(rows, output):
    """Prints the table and writes it to the output folder; True when everything holds."""
    lines = ["# Recorded drives with a spoilt wheel", "", "| drive | wheel | fault | drift | left out in the second half | |",
             "|---|---|---|---|---|---|"]
    for row in rows:
        verdict = "" if not row.wheel else "ok" if row.names() and row.bears() else "**not named**" if not row.names() else "**drifts**"
        lines.append(f"| {row.drive} | {row.wheel} | {row.fault} | {row.drift:.2f} % | {row.said} | {verdict} |")
    spoilt = [row for row in rows if row.wheel]
    named, bearing = sum(row.names() for row in spoilt), sum(row.bears() for row in spoilt)
    lines += ["", f"{named} of {len(spoilt)} are named, {bearing} of {len(spoilt)} drift no more than allowed."]
    print("\n".join(lines))
    (output / "faults.md").write_text("\n".join(lines) + "\n")
    return named == bearing == len(spoilt)


if __name__ == "__main__":
    sys.exit(evaluate_calibration.run(__doc__, "faults", evaluate, report))
