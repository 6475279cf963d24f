"""The package's tools, run as a user runs them, and what they leave behind."""

import pathlib
import subprocess
import sys

import rosbag

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import trajectory  # noqa: E402


class Package:
    """simulate and replay_bag, with their bags in a folder of their own."""

    def __init__(self, tools, folder):
        self._tools = pathlib.Path(tools)
        self._folder = pathlib.Path(folder)

    def simulate(self, name, scenario, config, *options):
        """A simulated drive; returns its bag."""
        bag = self._folder / f"{name}.bag"
        self._run("simulate", "--scenario", scenario, "--config", config, "--laser-rate", "0", "--output", bag,
                  *options)
        return bag

    def replay(self, bag, config, settings):
        """The odometry over a drive, with parameters set as {path: value}."""
        output = bag.with_suffix(".odometry.bag")
        pairs = [text for key, value in settings.items() for text in ("--set", f"{key}={value}")]
        self._run("replay_bag", bag, "--config", config, "--output", output, *pairs)
        return trajectory.read_odometry(str(output), "odom")

    def _run(self, tool, *arguments):
        command = [str(self._tools / tool), *map(str, arguments)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")


def truth_of(bag):
    """Where the simulated car truly was."""
    return trajectory.read_odometry(str(bag), "ground_truth")


def rear_ticks(bag):
    """Counters of the rear wheels in a bag: right and left, a row for each message."""
    with rosbag.Bag(str(bag)) as messages:
        return [(message.rear_right, message.rear_left)
                for _, message, _ in messages.read_messages(topics=["wheel_ticks", "/wheel_ticks"])]
