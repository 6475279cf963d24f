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
        cls.described = evaluate_recorded.load_yaml("fitted_drift.yaml")
        with tempfile.TemporaryDirectory() as folder:
            cls.found = evaluate_calibration.evaluate(DATA, tools, pathlib.Path(folder), GROUPS)

    def of(self, group, axles):
        """The calibration of a group."""
        return next(one.fitted for one in self.found if (one.group, one.axles) == (group, axles))

    def test_every_calibration_is_written(self):
        """The fit converges, and the wheels' gains are observed."""
        for one in self.found:
            with self.subTest(group=one.group, axles=one.axles):
                self.assertIsNotNone(one.fitted.path, one.fitted.said)
                gains = {name: parameter for name, parameter in one.fitted.parameters.items()
                         if name.endswith(("/k_r", "/k_l"))}
                self.assertEqual(len(gains), 4 if one.axles == "both" else 2)
                self.assertTrue(all(gain.observed for gain in gains.values()), one.fitted.said)

    def test_a_straight_drive_does_not_show_the_track(self):
        """k_b is reported as not observed, and stays where it was to a standard deviation of its prior."""
        gains = {(one.group, one.axles, name): gain for one in self.found if one.group in STRAIGHT
                 for name, gain in one.fitted.parameters.items() if name.endswith("/k_b")}
        self.assertEqual(len(gains), 4 * len(STRAIGHT))
        for name, gain in gains.items():
            with self.subTest(gain=name):
                self.assertFalse(gain.observed)
                self.assertLess(abs(gain.value - 1.0), gain.prior)

    def test_a_wheel_that_runs_fast(self):
        """Car n008's right rear wheel."""
        ratio = evaluate_calibration.rear_ratio(self.of("n008", "rear"))
        self.assertAlmostEqual(ratio / evaluate_calibration.REAR_RATIO, 1.0, delta=evaluate_calibration.RATIO_TOLERANCE)

    def test_drift(self):
        """At most the README's plus 0.1 % of the distance, but for the rows that are listed as missed."""
        for row in [row for one in self.found for row in one.rows]:
            with self.subTest(group=row.group, axles=row.axles, runs=row.runs):
                missed = self.described[row.group].get("missed", {}).get(row.axles, [])
                self.assertTrue(row.holds() or row.runs in missed, f"README {row.baseline} %, measured {row.fitted:.2f} %")


if __name__ == "__main__":
    xunit.main("calibration_recorded")
