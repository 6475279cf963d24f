"""The package's tools, run as a user runs them, and what they leave behind."""

import csv
import pathlib
import sys

import numpy as np
import rosbag

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import programs  # noqa: E402
import trajectory  # noqa: E402


class Package:
    """simulate, replay_bag and calibrate_bag, with what they write in a folder of their own."""

    def __init__(self, tools, folder):
        self._tools = pathlib.Path(tools)
        self._folder = pathlib.Path(folder)

    def simulate(self, name, scenario, config, *options):
        """A simulated drive; returns its bag. It has no laser poses, unless the options ask for them."""
        bag = self._folder / f"{name}.bag"
        laser = [] if "--laser-rate" in options else ["--laser-rate", "0"]
        programs.run(self._tools, "simulate", "--scenario", scenario, "--config", config, *laser, "--output", bag,
                     *options)
        return bag

    def replay(self, bag, config, settings):
        """The odometry over a drive, with parameters set as {path: value}."""
        output = bag.with_suffix(".odometry.bag")
        programs.run(self._tools, "replay_bag", bag, "--config", config, "--output", output,
                     *programs.settings(settings))
        return trajectory.read_odometry(str(output), "odom")

    def calibrate(self, name, bags, config, settings):
        """The calibration's filter over drives: {column: values}, a row for each laser pose."""
        report = self._folder / name
        programs.run(self._tools, "calibrate_bag", *bags, "--config", config, "--no-refine",
                     "--output", report.with_suffix(".yaml"), "--report", report, *programs.settings(settings))
        with open(report / "updates.csv", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        return dict(zip(head, np.array(rows, dtype=float).T))


def truth_of(bag):
    """Where the simulated car truly was."""
    return trajectory.read_odometry(str(bag), "ground_truth")


def rear_ticks(bag):
    """Counters of the rear wheels in a bag: right and left, a row for each message."""
    with rosbag.Bag(str(bag)) as messages:
        return [(message.rear_right, message.rear_left)
                for _, message, _ in messages.read_messages(topics=["wheel_ticks", "/wheel_ticks"])]
