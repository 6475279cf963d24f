#!/usr/bin/python3
"""The package's files are in order: catkin_lint without findings, every source file formatted, every erratum
of the papers tested, nothing in the sources that docs/reliability.md rules out."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/support"))
import reliability  # noqa: E402
import xunit  # noqa: E402


def run(*command):
    """The process, with its output as text."""
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


def clang_format_version():
    """Major version of clang-format, 0 when there is none."""
    if not shutil.which("clang-format"):
        return 0
    return int(re.search(r"version (\d+)", run("clang-format", "--version").stdout).group(1))


class Style(unittest.TestCase):
    """Tools that read the package without building it."""

    @unittest.skipUnless(shutil.which("catkin_lint"), "catkin_lint is not installed")
    def test_catkin_lint(self):
        """No errors, warnings or notices, but for the name that the checkout's folder happens to have."""
        lint = run("catkin_lint", "-W2", "--strict", "--offline", "--ignore", "package_path_name", str(ROOT))
        self.assertEqual(lint.returncode, 0, lint.stdout)

    # Other versions of clang-format break lines differently.
    @unittest.skipUnless(clang_format_version() == 14, "clang-format 14 is not installed")
    def test_clang_format(self):
        """.clang-format would change nothing."""
        sources = [str(path) for folder in ("include", "src", "test") for path in (ROOT / folder).rglob("*.[ch]pp")]
        formatted = run("clang-format", "--dry-run", "-Werror", *sources)
        self.assertEqual(formatted.returncode, 0, formatted.stdout[:4000])

    def test_errata(self):
        """Every erratum that docs/model.md lists has its test, and every such test its row."""
        rows = re.findall(r"^\| E(\d+) \|.*\| `(E\d+\w+)` \|$", (ROOT / "docs/model.md").read_text(), re.MULTILINE)
        sources = "".join(path.read_text() for path in (ROOT / "test/core").glob("errata_*_test.cpp"))
        self.assertEqual([int(number) for number, _ in rows], list(range(1, len(rows) + 1)))
        for number, name in rows:
            self.assertTrue(name.startswith(f"E{int(number):02d}"), f"row E{number} names {name}")
        self.assertCountEqual([name for _, name in rows], re.findall(r"TEST\(Errata, (\w+)\)", sources))


class Contract(unittest.TestCase):
    """Promises of docs/reliability.md that are kept by what the sources do not hold."""

    @staticmethod
    def lines_with(pattern, *folders):
        """File and text of every line of C++ that holds the pattern outside a comment."""
        sources = [path for folder in folders for path in (ROOT / folder).rglob("*.[ch]pp")]
        return [
            (path.name, line.strip())
            for path in sorted(sources)
            for line in path.read_text().splitlines()
            if re.search(pattern, line.split("//")[0])
        ]

    def test_every_row_has_a_test(self):
        """By the names of tests, as the table of results is written."""
        tests = []
        for path in sorted((ROOT / "test").rglob("*_test.cpp")):
            found = re.findall(r"^TEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\)", path.read_text(), re.MULTILINE)
            tests += [name for suite, name in found if reliability.is_of_the_contract(suite)]
        for path in (ROOT / "test").rglob("test_*.py"):
            tests += re.findall(r"^    def (test_\w+)\(self", path.read_text(), re.MULTILINE)
        tested = {row for name in tests for row in reliability.rows_of(name)}
        rows = reliability.contract_rows((ROOT / "docs/reliability.md").read_text())
        self.assertGreater(len(rows), 50)
        self.assertEqual([row for row in rows if row not in tested], [])
        # Those of the model's reference values (docs/model.md, 9) begin after the contract's.
        self.assertEqual(sorted(tested - set(rows)), ["T18", "T19", "T20"])

    def test_P5_parameters_are_read_in_one_place(self):
        """Nothing but the start asks the parameter server."""
        reading = r"ros::param|\b[gs]etParam\b|\bsearchParam|\bhasParam|\.param[<(]|\bparam<"
        found = self.lines_with(reading, "src", "include")
        self.assertEqual([name for name, _ in found], ["parameter_server.cpp"], found)

    def test_X2_no_shell(self):
        """Programs are started in one place, by their path and their arguments, and no node does it."""
        self.assertEqual(self.lines_with(r"\b(system|popen|wordexp|exec[lv]p?e?)\s*\(", "src", "include"), [])
        started = self.lines_with(r"\b(posix_spawnp?|fork)\s*\(", "src", "include")
        self.assertEqual([name for name, _ in started], ["program.cpp"], started)
        self.assertTrue((ROOT / "src/tools/program.cpp").is_file())

    def test_X2_no_service_takes_a_path(self):
        """Requests are empty, or two times."""
        for service in (ROOT / "srv").glob("*.srv"):
            request = service.read_text().split("---")[0]
            self.assertEqual(re.findall(r"^(\w+) \w+$", request, re.MULTILINE), ["time", "time"], service.name)
        types = self.lines_with(r"::Request&", "include")
        self.assertEqual(len(types), 6, types)
        for name, line in types:
            self.assertRegex(line, r"\((std_srvs::Trigger|const RelativeMotion|RelativeMotion)::Request& \w+"
                             if name != "relative_motion.hpp" else r"const RelativeMotion::Request& request")

    def test_N6_no_throttle_is_shared(self):
        """ROS' throttles keep their time in static variables, which cars in one manager would share."""
        found = self.lines_with(r"_THROTTLE\(|_ONCE\(", "src/ros", "include")
        self.assertEqual([name for name, _ in found if name != "simulated_car_node.cpp"], [], found)


if __name__ == "__main__":
    xunit.main("style")
