#!/usr/bin/python3
"""The table of results in docs/reliability.md, written from result files that are made up here."""

import contextlib
import io
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import reliability  # noqa: E402
import xunit  # noqa: E402

PAGE = f"""# Contract

| row | fault | what |
| --- | --- | --- |
| E1 | wraps | differences |
| E12 | never seen | nothing |
| T4 | future | drop |

{reliability.BEGIN}
old
{reliability.END}

| E7 | is no row of the contract |
"""

GTEST = """<testsuites><testsuite name="A/Suite">
  <testcase name="E1_wraps/8" status="run" classname="A/Suite" figure="off by 1.5 mm" />
  <testcase name="E1_wraps/16" status="run" classname="A/Suite">
    <properties><property name="figure" value="off by 0.5 mm"/></properties>
  </testcase>
  <testcase name="E1_T4_together" status="run" classname="Suite" figure="exact"/>
  <testcase name="E12_wheels_swapped_in_print" status="run" classname="Errata"/>
  <testcase name="withoutARow" status="run" classname="Suite"/>
</testsuite></testsuites>"""

PYTHON = """<testsuite name="style"><testcase classname="style" name="test_T4_style (__main__.Contract)">
  {}</testcase></testsuite>"""


class Table(unittest.TestCase):
    """The page after a run."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()  # pylint: disable=consider-using-with
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.page = self.folder / "page.md"
        self.page.write_text(PAGE)
        self.write("gtest-some_test.xml", GTEST)
        self.write("python-style.xml", PYTHON.format(""))

    def write(self, name, text):
        """A result file."""
        (self.folder / name).write_text(text)

    def run_main(self):
        """(exit status, what it says, {row: line})."""
        said = io.StringIO()
        with mock.patch.object(sys, "argv", ["reliability.py", str(self.folder), str(self.page)]), \
                contextlib.redirect_stderr(said):
            status = reliability.main()
        lines = self.page.read_text().split(reliability.BEGIN)[1].split(reliability.END)[0].splitlines()
        return status, said.getvalue(), {line.split(" | ")[0].strip("| "): line for line in lines if line}

    def test_results_and_figures(self):
        """Of tests with parameters the range, whichever way GoogleTest writes them."""
        _, _, rows = self.run_main()
        self.assertEqual(rows["E1"], "| E1 | some_test: `E1_wraps`, `E1_T4_together` | 3 passed | "
                                     "off by 0.5 to 1.5 mm; exact |")
        self.assertEqual(rows["T4"], "| T4 | some_test: `E1_T4_together`; style: `T4_style` | 2 passed | exact |")
        self.assertNotIn("old", self.page.read_text())
        self.assertTrue(self.page.read_text().endswith("| E7 | is no row of the contract |\n"))

    def test_a_row_without_a_test_is_seen(self):
        """In the table and by the exit status; the papers' errata are none."""
        status, said, rows = self.run_main()
        self.assertEqual(rows["E12"], "| E12 |  | **no test has run** |  |")
        self.assertEqual(status, 1)
        self.assertEqual(said, "page.md: no test has shown E12\n")

    def test_what_failed_or_was_skipped_is_seen(self):
        """A failure is one, however many others passed; what was skipped shows nothing."""
        for tag, word in (("failure", "failed"), ("error", "failed"), ("skipped", "skipped")):
            self.write("python-style.xml", PYTHON.format(f'<{tag} message="why"/>'))
            _, said, rows = self.run_main()
            self.assertIn(f"| 1 passed, **1 {word}** |", rows["T4"])
            self.assertEqual("T4" in said, word == "failed")

    def test_all_is_well(self):
        """And nothing is written a second time."""
        self.write("rosunit-other.xml", GTEST.replace("E1_T4", "E12").replace('classname="Errata"', 'classname="X"'))
        status, said, rows = self.run_main()
        self.assertEqual((status, said), (0, ""))
        self.assertIn("other.test: `E12_together`", rows["E12"])
        before = self.page.stat().st_mtime_ns
        self.run_main()
        self.assertEqual(self.page.stat().st_mtime_ns, before)

    def test_figures_of_python(self):
        """Go through the result file as those of GoogleTest do."""
        class Case(unittest.TestCase):
            """One that measures."""
            def test_T4_measures(self):
                """Something."""
                xunit.record_figure(self, "3 of 4")

        result = unittest.TextTestRunner(stream=io.StringIO(), resultclass=xunit._Result).run(  # pylint: disable=protected-access
            Case("test_T4_measures"))
        xunit._write(result, "style", self.folder / "python-style.xml")  # pylint: disable=protected-access
        self.assertIn("| exact; 3 of 4 |", self.run_main()[2]["T4"])

    def test_a_page_without_its_place(self):
        """Says what it needs, and leaves the page as it is."""
        self.page.write_text("# Contract\n")
        with self.assertRaisesRegex(ValueError, "the page needs one line"):
            self.run_main()
        self.assertEqual(self.page.read_text(), "# Contract\n")


if __name__ == "__main__":
    xunit.main("reliability")
