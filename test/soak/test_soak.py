#!/usr/bin/python3
"""What scripts/soak makes of its samples."""

import pathlib
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
import xunit  # noqa: E402

sys.path.insert(0, str(HERE))
import soak  # noqa: E402


def run(**columns):
    """Half an hour in which nothing grows, but for the columns given: functions of the second."""
    steady = {"messages": 1000, "p99_ms": 0.5, "resident_mb": 20.0, "threads": 9, "files": 30, "calibration_mb": 20.0,
              "log_kb": 10.0}
    rows = [{"second": second, **steady, **{name: value(second) for name, value in columns.items()}}
            for second in range(1, 1801)]
    return [dict(row, ages=[round(1000.0 * row["p99_ms"])] * 10) for row in rows]


def faults(**columns):
    """What is found in such a run."""
    return soak.faults(soak.figures(run(**columns)))


class Soak(unittest.TestCase):
    """Of what grows, and of what only seems to."""

    def test_N9_what_grows_is_found(self):
        """A slow leak, a latency that creeps up, a thread and a file that stay."""
        self.assertRegex(faults(resident_mb=lambda second: 20.0 + second / 1000.0)[0], "memory grew by 1.7")
        self.assertRegex(faults(p99_ms=lambda second: 0.5 + second / 10000.0)[0], "latency grew by 1.3")
        self.assertEqual(faults(messages=lambda second: 1000 if second < 900 else 0),
                         ["odometries fell from 1000 to 0 a second"])
        self.assertEqual(faults(threads=lambda second: 9 + (second > 900)), ["threads grew from 9 to 10"])
        self.assertEqual(faults(files=lambda second: 30 + (second > 1700)), ["files grew from 30 to 31"])

    def test_N9_what_settles_has_not_grown(self):
        """The first minute, one slow second, and a connection that comes and goes."""
        self.assertEqual(faults(), [])
        self.assertEqual(faults(resident_mb=lambda second: min(20.0, 10.0 + second)), [])
        self.assertEqual(faults(p99_ms=lambda second: 100.0 if second % 60 == 0 else 0.5), [])
        self.assertEqual(soak.percentile([500] * 995 + [100000] * 5), 0.5)
        self.assertEqual(faults(files=lambda second: 30 + (second % 60 == 0)), [])


if __name__ == "__main__":
    xunit.main("soak")
