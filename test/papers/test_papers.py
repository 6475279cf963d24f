#!/usr/bin/python3
"""docs/papers is complete, and its results are those of this code."""

import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
KEPT = ROOT / "docs/papers"
sys.path.insert(0, str(ROOT / "test/support"))
import xunit  # noqa: E402

RESULTS = sorted(path.name for path in KEPT.iterdir() if path.suffix in (".png", ".csv"))


def columns_of(path):
    """{name: values} of a CSV file."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


class Page(unittest.TestCase):
    """What is kept."""

    def test_links(self):
        """The page shows every result, and whatever it links to exists."""
        links = set(re.findall(r"\]\(([^)#]+)", (KEPT / "README.md").read_text(encoding="utf-8")))
        self.assertEqual([link for link in links if not (KEPT / link).exists()], [])
        self.assertEqual(set(RESULTS) - links, set())

    def test_pictures_are_small(self):
        """A picture of the page loads quickly."""
        for name in RESULTS:
            self.assertLess((KEPT / name).stat().st_size, 150000, name)

    def test_simulation_confirms_exact_moments(self):
        """All along the drive. 20 000 robots leave 0.5 % open in a standard deviation; four times that."""
        for name in ("paper2_sigmas_1mm.csv", "paper2_sigmas_3mm.csv"):
            columns = columns_of(KEPT / name)
            for coordinate in ("x", "y", "yaw"):
                pairs = zip(columns[f"exact_moments_{coordinate}"], columns[f"simulated_{coordinate}"])
                worst = max(abs(exact / simulated - 1.0) for exact, simulated in pairs if simulated > 0.0)
                self.assertLess(worst, 0.02, f"{name}: {coordinate}")


class Reproduction(unittest.TestCase):
    """A run with few robots."""

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.output = pathlib.Path(cls._folder.name)
        cls.done = subprocess.run(
            [sys.executable, str(KEPT / "reproduce_papers.py"), "--tools", os.environ["BS_CAR_ODOMETRY_TOOLS"],
             "--output", str(cls.output), "--runs", "500"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    def test_writes_what_is_kept(self):
        """The same files, no more and no fewer."""
        self.assertEqual(self.done.returncode, 0, self.done.stdout)
        self.assertEqual(sorted(path.name for path in self.output.iterdir()), sorted(RESULTS + ["README.md"]))

    def test_results_are_those_kept(self):
        """Run scripts/reproduce_papers where this fails. The simulation's columns vary with the number of robots."""
        self.assertEqual(self.done.returncode, 0, self.done.stdout)
        for name in (name for name in RESULTS if name.endswith(".csv")):
            kept, new = columns_of(KEPT / name), columns_of(self.output / name)
            self.assertEqual(list(kept), list(new), name)
            for column in (column for column in kept if not column.startswith("simulated")):
                # Six digits are written; the mathematics library of another system may round the last.
                difference = max(abs(a - b) for a, b in zip(kept[column], new[column]))
                self.assertLess(difference, 1e-4 * max(map(abs, kept[column])), f"{name}: {column}")


if __name__ == "__main__":
    xunit.main("papers")
