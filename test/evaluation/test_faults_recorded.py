#!/usr/bin/python3
"""Recorded four-wheel cars with one wheel's readings spoilt half way (row E7); skipped where there are none."""

import os
import pathlib
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]
import evaluate_faults  # noqa: E402
import evaluate_recorded  # noqa: E402
import xunit  # noqa: E402

DATA = evaluate_recorded.default_data_folder()
# One drive in town, one at a standstill in between, one on a motorway; scripts/evaluate_recorded has all.
GROUPS = ["n008", "comma"]


@unittest.skipUnless(DATA.is_dir(), f"no recordings in {DATA}")
class SpoiltRecordings(unittest.TestCase):
    """Every fault of every wheel."""

    @classmethod
    def setUpClass(cls):
        """Runs them once."""
        tools = pathlib.Path(os.environ["BS_CAR_ODOMETRY_TOOLS"])
        with tempfile.TemporaryDirectory() as folder:
            rows = evaluate_faults.evaluate(DATA, tools, pathlib.Path(folder), GROUPS)
        cls.spoilt = [row for row in rows if row.wheel]
        cls.untouched = [row for row in rows if not row.wheel]

    def test_E7_every_fault_is_named(self):
        """The wheel is left out longer than any other sensor."""
        self.assertEqual(len(self.spoilt), 3 * 4 * len(evaluate_faults.FAULTS))
        for row in self.spoilt:
            with self.subTest(drive=row.drive, wheel=row.wheel, fault=row.fault):
                self.assertTrue(row.names(), row.said)
        named = sum(row.names() for row in self.spoilt)
        xunit.record_figure(self, f"recorded cars: {named} of {len(self.spoilt)} spoilt wheels named")

    def test_E7_the_drift_without_the_wheel(self):
        """At most twice that of the untouched drive, or 0.5 % of the distance more."""
        for row in self.spoilt:
            with self.subTest(drive=row.drive, wheel=row.wheel, fault=row.fault):
                self.assertTrue(row.bears(), f"{row.drift:.2f} %, untouched {row.untouched:.2f} %")

    def test_E7_nothing_is_left_out_for_long_where_nothing_is_wrong(self):
        """A tenth of the second half: tyres slip now and then."""
        for row in self.untouched:
            with self.subTest(drive=row.drive):
                self.assertLess(row.shares.max(), 0.1, row.said)


if __name__ == "__main__":
    xunit.main("faults_recorded")
