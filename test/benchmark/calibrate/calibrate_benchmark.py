#!/usr/bin/env python3
"""calibrate_bag against rosbag that only reads the same messages: the filter over one hour at 100 Hz, everything with
noise and refinement over ten minutes, and the memory of ten hours. Every round runs all in turn; the ratios are of
medians over the rounds."""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

CONFIG = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../config/cycab.yaml")
HOUR, TEN_MINUTES, TEN_HOURS = 3600.0, 600.0, 36000.0
LIMITS = {"filter, one hour": 2.0, "refinement, ten minutes": 20.0}
MEMORY_LIMIT = 1024.0  # MiB, of ten hours


def simulate(tools, duration, path):
    """A drive with the calibration's inputs alone: reading other topics would only make the baseline slower."""
    subprocess.check_call(
        [os.path.join(tools, "simulate"), "--scenario", "slalom_eight", "--config", CONFIG, "--rate", "100", "--duration",
         str(duration), "--no-truth", "--output", path], stdout=subprocess.DEVNULL)


def run(command):
    """(seconds of the wall clock, seconds of the processor, MiB) that a program takes, its start and end included."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)  # pylint: disable=consider-using-with
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def baseline(arguments, path):
    """Seconds that rosbag takes to read, as the baseline measures it around nothing else."""
    command = [arguments.baseline, "read", path]
    return tuple(map(float, subprocess.check_output(command, stderr=subprocess.DEVNULL).split()))


def calibrate(arguments, path, output, options):
    """One run of the tool."""
    return run([os.path.join(arguments.tools, "calibrate_bag"), path, "--config", CONFIG, "--output", output] + options)


def measure_round(arguments, bags, output):
    """{name: (time of the tool, time of reading)}, each (wall clock, processor)."""
    return {
        "filter, one hour": (calibrate(arguments, bags[HOUR], output, ["--no-refine"])[:2],
                             baseline(arguments, bags[HOUR])),
        "refinement, ten minutes": (calibrate(arguments, bags[TEN_MINUTES], output, [])[:2],
                                    baseline(arguments, bags[TEN_MINUTES])),
    }


def report(rounds):
    """Prints the table; true when the limits hold."""
    passed = True
    print(f"medians of {len(rounds)} rounds          tool [s]   rosbag reads [s]   ratio   of processor time")
    for name, limit in LIMITS.items():
        tool, reading = ([statistics.median(round_[name][kind][clock] for round_ in rounds) for clock in (0, 1)]
                         for kind in (0, 1))
        passed = passed and tool[0] <= limit * reading[0]
        print(f"  {name:25} {tool[0]:9.3f} {reading[0]:18.3f} {tool[0] / reading[0]:7.2f} {tool[1] / reading[1]:19.2f}"
              f"   at most {limit}")
    return passed


def main():
    """Makes the bags, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tools", required=True, help="folder of calibrate_bag and simulate")
    parser.add_argument("--baseline", required=True, help="the program rosbag_baseline")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--no-memory", action="store_true", help="without the ten hours")
    arguments = parser.parse_args()
    passed = True
    with tempfile.TemporaryDirectory() as folder:
        bags = {duration: os.path.join(folder, f"{duration:.0f}.bag") for duration in (HOUR, TEN_MINUTES, TEN_HOURS)}
        output = os.path.join(folder, "cal.yaml")
        for duration in (HOUR, TEN_MINUTES):
            simulate(arguments.tools, duration, bags[duration])
        rounds = [measure_round(arguments, bags, output) for _ in range(arguments.rounds + 1)]
        passed = report(rounds[1:])  # the first round fills the caches
        if not arguments.no_memory:
            simulate(arguments.tools, TEN_HOURS, bags[TEN_HOURS])
            seconds, _, memory = calibrate(arguments, bags[TEN_HOURS], output, [])
            passed = passed and memory <= MEMORY_LIMIT
            print(f"  memory of ten hours {memory:.0f} MiB, at most {MEMORY_LIMIT:.0f} MiB ({seconds:.1f} s)")
    print("pass" if passed else "fail")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
