#!/usr/bin/python3
"""Odometry and calibration at 1 kHz for a long time: what they take of the machine every second, and how late the
odometry is. Writes soak.csv and soak.png, prints the figures; ends with 1 when one of them has grown."""

import argparse
import array
import csv
import itertools
import os
import pathlib
import select
import shutil
import signal
import statistics
import subprocess
import sys
import xmlrpc.client

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend has to be chosen first)

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
from ros_session import free_port, running  # noqa: E402

COLUMNS = ("second", "messages", "p99_ms", "resident_mb", "threads", "files", "calibration_mb", "log_kb")
MINUTE = 60  # samples
AROUND = 10  # samples of which one figure is the median, so that a connection that comes and goes does not count
PATIENCE = 60.0  # s, until the first odometry, and between two reports
MOST_GROWTH_MB = 1.0
MOST_RATIO = 1.2
LEAST_SHARE = 0.9  # of the odometries of each second


def parse_arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, required=True)
    parser.add_argument("--driver", required=True, help="program that drives and reports every second")
    parser.add_argument("--output", type=pathlib.Path, required=True, metavar="FOLDER")
    arguments = parser.parse_args()
    if arguments.minutes * MINUTE < 2 * AROUND:
        parser.error(f"--minutes must be at least {2 * AROUND / MINUTE:.2f}")
    return arguments


def size_of(process):
    """Resident memory [MB], threads and open files of a process."""
    folder = pathlib.Path("/proc") / str(process)
    fields = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines())
    return int(fields["VmRSS"].split()[0]) / 1024.0, int(fields["Threads"]), len(list((folder / "fd").iterdir()))


def process_of(node, master):
    """Process id of a node, as it says itself."""
    code, text, address = xmlrpc.client.ServerProxy(master).lookupNode("/soak", node)
    if code != 1:
        raise RuntimeError(f"{node} does not run: {text}")
    return xmlrpc.client.ServerProxy(address).getPid("/soak")[2]


def report_of(driver):
    """Ages [us] of the odometries that the driver heard in its next second."""
    while True:  # ROS writes its own lines between them
        if not select.select([driver.stdout], [], [], PATIENCE)[0]:
            raise RuntimeError("the driver says nothing")
        line = driver.stdout.readline()
        if not line:
            raise RuntimeError("the driver has ended")
        words = line.split()
        if words and words[0] == b"soak":
            return array.array("q", map(int, words[1:]))


def percentile(ages):
    """99th percentile [ms] of ages [us]; 0 of none."""
    return sorted(ages)[len(ages) * 99 // 100] / 1000.0 if ages else 0.0


def wait_for_odometry(driver):
    """Returns after the first whole second of odometry."""
    for _ in range(int(PATIENCE)):
        if report_of(driver):
            report_of(driver)
            return
    raise RuntimeError(f"no odometry within {PATIENCE:.0f} s")


def sample(second, driver, processes, logs):
    """One row of the table, with the ages of all its odometries; waits for the end of the second."""
    ages = report_of(driver)
    resident, threads, files = size_of(processes[0])
    log_bytes = sum(path.stat().st_size for path in logs.rglob("*") if path.is_file() and not path.is_symlink())
    row = dict(zip(COLUMNS, (second, len(ages), percentile(ages), resident, threads, files, size_of(processes[1])[0],
                             log_bytes / 1024.0)))
    return dict(row, ages=ages)


def soak(arguments, write):
    """Runs everything, and writes every sample as it comes."""
    logs = arguments.output / "log"
    shutil.rmtree(logs, ignore_errors=True)
    logs.mkdir(parents=True)
    port = free_port()
    master = f"http://127.0.0.1:{port}"
    environment = dict(os.environ, ROS_MASTER_URI=master, ROS_LOG_DIR=str(logs))
    with open(logs / "roslaunch.log", "wb") as log, \
            running(["roslaunch", "-p", str(port), str(HERE / "soak.launch")], env=environment, stdout=log, stderr=log), \
            running([arguments.driver], env=environment, stdout=subprocess.PIPE, stderr=log) as driver:
        wait_for_odometry(driver)
        processes = [process_of(node, master) for node in ("/manager", "/calibration")]
        for second in range(1, round(arguments.minutes * MINUTE) + 1):
            write(sample(second, driver, processes, logs))


def settling(samples):
    """Seconds that everything may take to settle: a minute, or half of a shorter run."""
    return min(MINUTE, len(samples) // 2)


def figures(samples):
    """What is compared, as {name: (first, last)}: the medians of ten seconds after it has settled, and of the last ten;
    of the latency the 99th percentiles of the first and of the last minute, and of the quietest second of both, which
    tells what is the odometry's own on a machine that does something else as well."""
    settled = settling(samples)

    def median(column, part):
        return statistics.median(row[column] for row in part)

    compared = {column: (median(column, samples[settled:settled + AROUND]), median(column, samples[-AROUND:]))
                for column in COLUMNS if column not in ("second", "p99_ms")}
    minutes = (samples[:settled], samples[-settled:])
    compared["p99_ms"] = tuple(percentile(list(itertools.chain.from_iterable(row["ages"] for row in part)))
                               for part in minutes)
    compared["quietest_ms"] = tuple(min(row["p99_ms"] for row in part) for part in minutes)
    return compared


def faults(compared):
    """A sentence for everything that has grown by more than it may."""
    found = []
    growth = compared["resident_mb"][1] - compared["resident_mb"][0]
    if growth >= MOST_GROWTH_MB:
        found.append(f"memory grew by {growth:.2f} MB")
    ratio = compared["p99_ms"][1] / compared["p99_ms"][0]
    if ratio > MOST_RATIO:
        found.append(f"the 99th percentile of the latency grew by {ratio:.2f}")
    if compared["messages"][1] < LEAST_SHARE * compared["messages"][0]:
        found.append("odometries fell from {:.0f} to {:.0f} a second".format(*compared["messages"]))
    for column in ("threads", "files"):
        if compared[column][1] > compared[column][0]:
            found.append(f"{column} grew from {compared[column][0]:.0f} to {compared[column][1]:.0f}")
    return found


def lines(samples, compared):
    """The figures in words."""
    def growth(column):
        first, last = compared[column]
        return f"{first:.2f} to {last:.2f} MB, {last - first:+.2f} MB"

    first, last = compared["p99_ms"]
    return [
        f"{len(samples)} s, {sum(row['messages'] for row in samples)} odometries; after {settling(samples)} s and at the end:",
        f"memory             {growth('resident_mb')}",
        f"calibration_node   {growth('calibration_mb')}",
        f"threads            {compared['threads'][0]:.0f} to {compared['threads'][1]:.0f}",
        f"open files         {compared['files'][0]:.0f} to {compared['files'][1]:.0f}",
        f"log                {samples[0]['log_kb']:.1f} to {samples[-1]['log_kb']:.1f} kB in all",
        f"latency            99th percentile of the first and of the last {settling(samples)} s: {first:.3f} and "
        f"{last:.3f} ms, ratio {last / first:.2f}",
        "                   of the quietest second of both: {:.3f} and {:.3f} ms".format(*compared["quietest_ms"]),
    ]


def draw(samples, path):
    """Memory, threads with files, latency and log over time."""
    minutes = [row["second"] / MINUTE for row in samples]
    figure, axes = plt.subplots(4, 1, figsize=(9, 10), sharex=True)
    curves = (
        ("resident memory [MB]", {"resident_mb": "manager with odometry", "calibration_mb": "calibration_node"}),
        ("count", {"threads": "threads of the manager", "files": "its open files"}),
        ("latency [ms]", {"p99_ms": "99th percentile of each second"}),
        ("log [kB]", {"log_kb": "all log files"}),
    )
    for panel, (label, columns) in zip(axes, curves):
        for column, name in columns.items():
            panel.plot(minutes, [row[column] for row in samples], linewidth=1.0, label=name)
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
        panel.legend(loc="best")
    axes[2].set_yscale("log")
    for panel in (axes[0], axes[1], axes[3]):
        panel.set_ylim(0.0, 1.15 * panel.get_ylim()[1])
    axes[-1].set_xlabel("time [min]")
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main():
    """Runs, writes, compares."""
    arguments = parse_arguments()
    arguments.output.mkdir(parents=True, exist_ok=True)
    # What was started is stopped on the way out; also in the background, where a shell has SIGINT ignored.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: sys.exit(128 + received))
    samples = []
    with open(arguments.output / "soak.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()

        def write(row):
            samples.append(row)
            table.writerow({name: round(row[name], 4) for name in COLUMNS})
            file.flush()

        try:
            soak(arguments, write)
        except (OSError, RuntimeError) as error:
            return f"soak: {error}; see {arguments.output}/log"
    draw(samples, arguments.output / "soak.png")
    compared = figures(samples)
    print("\n".join(lines(samples, compared)))
    found = faults(compared)
    print("\n".join(f"FAILED: {fault}" for fault in found) or "nothing has grown")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
