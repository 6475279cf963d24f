#!/usr/bin/python3
"""summarise.py FOLDER: what failed under a folder of test results, then one line `N passed, N failed`.

Counts the same files as catkin_test_results, but every test once: that tool adds the sums of a GoogleTest file
to those of its suites. Ends with 1 when a test failed, or when there was none.
"""

import pathlib
import sys
from xml.etree import ElementTree


def outcome(case):
    """failed, skipped or passed."""
    if case.find("failure") is not None or case.find("error") is not None:
        return "failed"
    if case.find("skipped") is not None or case.get("status") == "notrun":
        return "skipped"
    return "passed"


def cases(path):
    """(file, testcase) of one result file. A rostest repeats the tests of its nodes as one case for each node,
    which says something new only when it failed, such as by a crash."""
    try:
        found = ElementTree.parse(path).iter("testcase")
    except ElementTree.ParseError as error:
        broken = ElementTree.Element("testcase", name="result file")
        ElementTree.SubElement(broken, "failure").text = str(error)
        found = [broken]
    is_rostest = path.name.startswith("rostest-")
    return [(path, case) for case in found if not is_rostest or outcome(case) == "failed"]


def message(case):
    """Everything that the failures of a case say."""
    parts = [part for tag in ("failure", "error") for part in case.iter(tag)]
    return "\n".join((part.text or part.get("message") or "").strip() for part in parts)


def main():
    """Prints the failures, the reasons for what was skipped, and the sums."""
    count = {"passed": 0, "failed": 0, "skipped": 0}
    for path in sorted(pathlib.Path(sys.argv[1]).rglob("*.xml")):
        for _, case in cases(path):
            count[outcome(case)] += 1
            name = f"{path.stem}: {case.get('name')}"
            if outcome(case) == "failed":
                print(f"FAILED  {name}\n        " + message(case).replace("\n", "\n        "))
            elif outcome(case) == "skipped":
                reason = case.find("skipped")
                print(f"skipped {name}" + (f" ({reason.get('message')})" if reason is not None else ""))
    skipped = f", {count['skipped']} skipped" if count["skipped"] else ""
    print(f"{count['passed']} passed, {count['failed']} failed{skipped}")
    return 1 if count["failed"] or not count["passed"] else 0


if __name__ == "__main__":
    sys.exit(main())
