#!/usr/bin/python3
"""The package's files are in order: catkin_lint without findings, every source file formatted, every erratum
of the papers tested."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/support"))
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


if __name__ == "__main__":
    xunit.main("style")
