#!/usr/bin/python3
"""Prints what ThreadSanitizer found in this package, of its reports in a folder; ends with 1 when there is something.

The libraries of ROS are not built with ThreadSanitizer, which sees what they read, write and free, and not that their
counted pointers keep order. So a data race counts where both accesses are this package's, and a pair of locks where one
of them is: that is where the innermost frame, headers of others left out, stands in its sources.
"""

import pathlib
import re
import sys

OURS = re.compile(r"(^|/)(src|test|include/bs_car_odometry)/[\w/]+\.[ch]pp:\d+")
HEADERS = re.compile(r"libsanitizer/|libtsan\.so|/usr/include/|/usr/lib/")
ACCESS = re.compile(r"(Previous )?(atomic )?(write|read) of size", re.IGNORECASE)
LOCK = re.compile(r"Mutex \S+ acquired here")


def stacks(report):
    """[(headline, [frame])] of a report."""
    found = []
    for line in report.splitlines():
        if re.match(r" +#\d+ ", line):
            if found:
                found[-1][1].append(line)
        elif line.strip():
            found.append((line.strip(), []))
    return found


def is_ours(frames):
    """What was done was done by this package; a stack that was not kept may have been its own."""
    innermost = next((frame for frame in frames if not HEADERS.search(frame)), None)
    return innermost is None or bool(OURS.search(innermost))


def concerns_us(report):
    """The report is of this package, and not of a library."""
    found = stacks(report)
    accesses = [is_ours(frames) for headline, frames in found if ACCESS.match(headline)]
    locks = [is_ours(frames) for headline, frames in found if LOCK.match(headline)]
    if accesses:
        return all(accesses)
    return any(locks) if locks else any(is_ours(frames) for _, frames in found)


def reports(folder):
    """All of them, each as text."""
    for path in sorted(pathlib.Path(folder).iterdir()):
        for report in path.read_text(errors="replace").split("==================\n"):
            if "WARNING: ThreadSanitizer" in report:
                yield report


def main(folder):
    """Prints, and counts."""
    everything = list(reports(folder))
    if not everything:
        print("not a single report, not even of ROS: was ThreadSanitizer there?")
        return 1
    ours = [report for report in everything if concerns_us(report)]
    print("\n".join(ours))
    print(f"{len(ours)} findings in this package, {len(everything) - len(ours)} reports of libraries that are built without")
    return 1 if ours else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
