#!/usr/bin/env python3
"""replay_bag over one hour at 100 Hz, against rosbag that only reads the same messages, or reads them and writes
the same results. Every round runs all four in turn; the ratios are of medians over the rounds."""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

CONFIG = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../config/cycab.yaml")
LIMITS = {"TUM": 1.8, "bag": 1.25}


def timed(command):
    """Seconds of the wall clock and of the processor that a program takes, its start and end included."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)  # pylint: disable=consider-using-with
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime


def baseline(command):
    """Seconds that rosbag takes, as the baseline measures it around nothing else."""
    return tuple(map(float, subprocess.check_output(command, stderr=subprocess.DEVNULL).split()))


def measure_round(arguments, folder):
    """One run of everything; (wall clock, processor) of each."""
    recorded, replayed = os.path.join(folder, "in.bag"), os.path.join(folder, "out.bag")
    replay = [os.path.join(arguments.tools, "replay_bag"), recorded, "--config", CONFIG]
    return {
        "rosbag reads": baseline([arguments.baseline, "read", recorded]),
        "replay_bag --tum": timed(replay + ["--tum", os.path.join(folder, "out.tum")]),
        "replay_bag --output": timed(replay + ["--output", replayed]),
        "rosbag writes": baseline([arguments.baseline, "write", replayed, os.path.join(folder, "copy.bag")]),
    }


def medians(rounds, clock):
    """Of every program's rounds; clock 0: wall, 1: processor."""
    return {name: statistics.median(round_[name][clock] for round_ in rounds) for name in rounds[0]}


def ratios(seconds):
    """What is to be shown."""
    both = seconds["rosbag reads"] + seconds["rosbag writes"]
    return {"TUM": seconds["replay_bag --tum"] / seconds["rosbag reads"], "bag": seconds["replay_bag --output"] / both}


def report(rounds):
    """Prints the table; true when the limits hold."""
    wall, processor = medians(rounds, 0), medians(rounds, 1)
    print(f"medians of {len(rounds)} rounds [s]      wall   processor")
    for name, seconds in wall.items():
        print(f"  {name:25} {seconds:9.3f} {processor[name]:9.3f}")
    passed = True
    for name, limit in LIMITS.items():
        passed = passed and ratios(wall)[name] <= limit
        print(f"  ratio, {name:18} {ratios(wall)[name]:9.2f} {ratios(processor)[name]:9.2f}   at most {limit}")
    print("pass" if passed else "fail")
    return passed


def main():
    """Makes the bag, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tools", required=True, help="folder of replay_bag and simulate")
    parser.add_argument("--baseline", required=True, help="the program rosbag_baseline")
    parser.add_argument("--duration", type=float, default=3600.0, help="of the recorded drive [s]")
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        # Nothing but the odometry's inputs: reading other topics would only make the baseline slower.
        subprocess.check_call(
            [os.path.join(arguments.tools, "simulate"), "--scenario", "slalom_eight", "--config", CONFIG, "--rate", "100",
             "--duration", str(arguments.duration), "--no-truth", "--laser-rate", "0", "--output",
             os.path.join(folder, "in.bag")], stdout=subprocess.DEVNULL)
        rounds = [measure_round(arguments, folder) for _ in range(arguments.rounds + 1)]
    return 0 if report(rounds[1:]) else 1  # the first round fills the caches


if __name__ == "__main__":
    sys.exit(main())
