#!/usr/bin/python3
"""Recorded drives reproduce the drift that their READMEs state; skipped where there are no recordings."""

import os
import pathlib
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]
import evaluate_recorded  # noqa: E402
import xunit  # noqa: E402

DATA = evaluate_recorded.default_data_folder()


@unittest.skipUnless(DATA.is_dir(), f"no recordings in {DATA}")
class RecordedDrives(unittest.TestCase):
    """All recordings with two or four wheels, nominal geometry."""

    @classmethod
    def setUpClass(cls):
        """Evaluates every run once."""
        tools = pathlib.Path(os.environ["BS_CAR_ODOMETRY_TOOLS"])
        with tempfile.TemporaryDirectory() as bags:
            cls.runs = evaluate_recorded.Evaluation(DATA, tools, pathlib.Path(bags)).run_all()

    def test_every_run_is_there(self):
        """Nothing is left out silently."""
        self.assertEqual(len(self.runs), 6 + 1 + 52)

    def test_nominal_drift(self):
        """Equation (2) drifts as the README says, for every figure given there."""
        for check in evaluate_recorded.checks(self.runs):
            with self.subTest(runs=check.runs, method=check.method):
                self.assertTrue(check.holds(), f"README {check.stated} %, measured {check.measured:.2f} %")


if __name__ == "__main__":
    xunit.main("recorded")
