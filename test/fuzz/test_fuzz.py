#!/usr/bin/python3
"""Every fuzz target runs without a finding, a minute for all together; `scripts/fuzz` runs them for longer."""

import os
import pathlib
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "support"))
import xunit  # noqa: E402
from run_targets import CORPUS, TARGETS, WORKERS, run_all  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("BS_CAR_ODOMETRY_BUILD", HERE.parents[1] / ".work/build")) / "fuzz"
SECONDS = 60


class Fuzz(unittest.TestCase):
    """libFuzzer with its sanitisers."""

    @unittest.skipUnless((PROGRAMS / "fuzz_step").exists(), "clang with libFuzzer is not installed")
    def test_targets(self):
        """Each gets its share of the time, and runs more than the inputs that it begins with."""
        for run in run_all(PROGRAMS, f"-max_total_time={SECONDS * min(WORKERS, len(TARGETS)) // len(TARGETS)}"):
            print(run, file=sys.stderr)
            with self.subTest(run.target):
                self.assertTrue(run.sound, run.output[-6000:])
                self.assertGreater(run.runs, len(list((CORPUS / run.target).iterdir())))

    def test_corpus(self):
        """Every target has one and every one has a target; its files are small, and few."""
        self.assertEqual(sorted(path.stem for path in HERE.glob("*.cpp")), TARGETS)
        for target in TARGETS:
            sizes = [path.stat().st_size for path in (CORPUS / target).iterdir()]
            self.assertLessEqual(len(sizes), 60, target)
            self.assertLess(max(sizes), 4096, target)


if __name__ == "__main__":
    xunit.main("fuzz")
