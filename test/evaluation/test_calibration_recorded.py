#!/usr/bin/python3
"""Gains fitted over recorded drives, against what the recordings' READMEs fit; skipped where there are none."""

import os
import pathlib
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]
import evaluate_calibration  # noqa: E402
import evaluate_recorded  # noqa: E402
import xunit  # noqa: E402

DATA = evaluate_recorded.default_data_folder()
# All but the 23 runs of optiodom_winter, whose noise and whose fits without one run take half a minute.
GROUPS = ["n008", "n015", "comma", "optiodom_june"]
# Drives with next to no turning.
STRAIGHT = ["n008", "comma"]


@unittest.skipUnless(DATA.is_dir(), f"no recordings in {DATA}")
class CalibratedRecordings(unittest.TestCase):
    """One calibration for every car and choice of axles."""

    @classmethod
    def setUpClass(cls):
        """Calibrates every group once."""
        tools = pathlib.Path(os.environ["BS_CAR_ODOMETRY_TOOLS"])
        with tempfile.TemporaryDirectory() as folder:
            cls.found = evaluate_calibration.evaluate(DATA, tools, pathlib.Path(folder), GROUPS)

    def calibrations(self):
        """(group, axles, objective) and what the fit by it came to."""
        for one in self.found:
            for objective in evaluate_calibration.OBJECTIVES:
                yield (one.group, one.axles, objective), one.calibrations[objective]

    def test_every_calibration_is_written(self):
        """The fit converges, and the wheels' gains are observed."""
        for what, calibration in self.calibrations():
            with self.subTest(what=what):
                self.assertIsNotNone(calibration.path, calibration.said)
                gains = {name: parameter for name, parameter in calibration.parameters.items()
                         if name.endswith(("/k_r", "/k_l"))}
                self.assertEqual(len(gains), 4 if what[1] == "both" else 2)
                self.assertTrue(all(gain.observed for gain in gains.values()), calibration.said)

    def test_a_straight_drive_does_not_show_the_track(self):
        """k_b is reported as not observed, and stays where it was to a standard deviation of its prior."""
        gains = {(*what, name): gain for what, calibration in self.calibrations() if what[0] in STRAIGHT
                 for name, gain in calibration.parameters.items() if name.endswith("/k_b")}
        self.assertEqual(len(gains), 8 * len(STRAIGHT))
        for name, gain in gains.items():
            with self.subTest(gain=name):
                self.assertFalse(gain.observed)
                self.assertLess(abs(gain.value - 1.0), gain.prior)
                if "path" in name:
                    self.assertEqual(gain.value, 1.0)

    def test_a_wheel_that_runs_fast(self):
        """Car n008's right rear wheel."""
        for what, calibration in self.calibrations():
            if what[:2] != ("n008", "rear"):
                continue
            with self.subTest(what=what):
                ratio = evaluate_calibration.rear_ratio(calibration)
                self.assertAlmostEqual(ratio / evaluate_calibration.REAR_RATIO, 1.0,
                                       delta=evaluate_calibration.RATIO_TOLERANCE)

    def test_drift(self):
        """At most the README's plus 0.1 % of the distance, by the objective that is the READMEs'."""
        rows = [row for one in self.found for row in one.rows]
        self.assertEqual(sum(row.baseline is not None for row in rows), 14)
        for row in rows:
            with self.subTest(group=row.group, axles=row.axles, runs=row.runs):
                self.assertTrue(row.holds(), f"README {row.baseline} %, measured {row.drifts['path']:.2f} %")


if __name__ == "__main__":
    xunit.main("calibration_recorded")
