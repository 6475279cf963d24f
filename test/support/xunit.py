"""Runs the unittest cases of a script and writes the result file that catkin_test_results reads.

rosunit would do, but counts a skipped test as passed.
"""

import argparse
import pathlib
import sys
import time
import unittest
from xml.etree import ElementTree


def record_figure(test, text):
    """What a test has measured, for the table of results in docs/reliability.md, as recordFigure() of the C++ tests."""
    print(text)
    test.figure = text


class _Result(unittest.TextTestResult):
    """Remembers how each test ended: (name, seconds, tag, message, figure), tag None where it passed."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.ended = []
        self._started = 0.0

    def startTest(self, test):
        super().startTest(test)
        self._started = time.monotonic()

    def addSuccess(self, test):
        super().addSuccess(test)
        self._end(test, None, "")

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self._end(test, "skipped", reason)

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self._end(test, "failure", self._exc_info_to_string(err, test))

    def addError(self, test, err):
        super().addError(test, err)
        self._end(test, "error", self._exc_info_to_string(err, test))

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self._end(subtest, "failure", self._exc_info_to_string(err, test))

    def _end(self, test, tag, message):
        self.ended.append((str(test), time.monotonic() - self._started, tag, message, getattr(test, "figure", None)))


def _write(result, suite_name, path):
    tags = [tag for _, _, tag, _, _ in result.ended]
    suite = ElementTree.Element(
        "testsuite", name=suite_name, tests=str(len(tags)), failures=str(tags.count("failure")),
        errors=str(tags.count("error")), skipped=str(tags.count("skipped")))
    for name, seconds, tag, message, figure in result.ended:
        case = ElementTree.SubElement(suite, "testcase", classname=suite_name, name=name, time=f"{seconds:.3f}")
        if figure:
            case.set("figure", figure)
        if tag:
            ElementTree.SubElement(case, tag, message=message.strip().splitlines()[-1]).text = message
    pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)  # the first test to run finds none
    ElementTree.ElementTree(suite).write(path, encoding="utf-8", xml_declaration=True)


def main(suite_name):
    """Runs the tests of the calling script; `--xunit FILE` writes the results, a name selects one test."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--xunit", metavar="FILE")
    parser.add_argument("names", nargs="*", help="TestCase or TestCase.test (default: all)")
    arguments = parser.parse_args()
    loader = unittest.defaultTestLoader
    module = sys.modules["__main__"]
    suite = loader.loadTestsFromNames(arguments.names, module) if arguments.names else loader.loadTestsFromModule(module)
    result = unittest.TextTestRunner(resultclass=_Result, verbosity=2).run(suite)
    if arguments.xunit:
        _write(result, suite_name, arguments.xunit)
    sys.exit(0 if result.wasSuccessful() else 1)
