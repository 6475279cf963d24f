#!/usr/bin/python3
"""Runs the fuzz targets, as many at a time as there are processors; prints runs, rate and coverage of each.

run_targets.py FOLDER [SECONDS | --runs RUNS]: FOLDER holds the programs; what they find is kept there, and begun
with the next time. Ends with 1 on a finding: a crash, a report of a sanitiser, a leak, an input that takes half a
minute or a gigabyte.
"""

import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import time

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"
TARGETS = sorted(path.name for path in CORPUS.iterdir())
# Without its entropic schedule libFuzzer makes up to twice the runs: that counts features of all inputs after each.
OPTIONS = ["-seed=1", "-max_len=4096", "-entropic=0", "-rss_limit_mb=1024", "-timeout=30", "-print_final_stats=1"]
# A good part of the time would go into where memory was allocated and into memory that is kept back: an input that fails
# tells more when it is run again, alone.
SANITISER = "detect_leaks=1:malloc_context_size=1:quarantine_size_mb=1:thread_local_quarantine_size_kb=64"
WORKERS = os.cpu_count() or 1


class Run:
    """One target, run to its end."""

    def __init__(self, folder, target, limit):
        found = folder / "corpus" / target
        found.mkdir(parents=True, exist_ok=True)
        # rosbag keeps some memory of each bag, which would be searched for leaks each time: that target does it itself.
        command = [folder / f"fuzz_{target}", limit, *OPTIONS, f"-detect_leaks={int(target != 'bag')}",
                   f"-artifact_prefix={folder}/{target}-", found, CORPUS / target]
        began = time.monotonic()
        process = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                                 env=dict(os.environ, ASAN_OPTIONS=SANITISER), check=False)
        self.seconds = time.monotonic() - began
        self.target = target
        self.sound = process.returncode == 0
        self.output = process.stdout
        self.runs = self._last(r"number_of_executed_units: *(\d+)")
        self.edges = self._last(r"cov: (\d+)")

    def _last(self, pattern):
        return int((re.findall(pattern, self.output) or [0])[-1])

    def __str__(self):
        return (f"{self.target}: {self.runs} runs, {self.runs / self.seconds:.0f} per second, "
                f"{self.edges} edges")


def run_all(folder, limit):
    """Yields the runs as they end."""
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        runs = [pool.submit(Run, folder, target, limit) for target in TARGETS]
        yield from (run.result() for run in concurrent.futures.as_completed(runs))


def main():
    """The command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("seconds", type=int, nargs="?", default=60)
    parser.add_argument("--runs", type=int)
    arguments = parser.parse_args()
    limit = f"-runs={arguments.runs}" if arguments.runs else f"-max_total_time={arguments.seconds}"
    status = 0
    for run in run_all(arguments.folder.resolve(), limit):
        print(run, flush=True)
        if not run.sound:
            print(run.output[-6000:], file=sys.stderr)
            status = 1
    sys.exit(status)


if __name__ == "__main__":
    main()
