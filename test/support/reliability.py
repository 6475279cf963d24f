#!/usr/bin/python3
"""reliability.py FOLDER PAGE: writes the results of the tests, as far as they are under FOLDER, into the page
docs/reliability.md: one line for each row of its contract, from the tests that carry the row's name, such as
`T4_future_stamp_is_dropped`. Ends with 1 when a row has no test that passed, or one that did not."""

import pathlib
import re
import sys
from collections import Counter
from xml.etree import ElementTree

import summarise

BEGIN = "<!-- written by scripts/test: results -->"
END = "<!-- written by scripts/test: end -->"
ROW = r"[CENOPSTX][1-9]\d?"
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def contract_rows(page):
    """Names of the rows of the tables above the results, in their order."""
    return re.findall(rf"^\| ({ROW}) \|", page.split(BEGIN)[0], re.MULTILINE)


def rows_of(name):
    """Rows that the name of a test carries in front."""
    carried = re.match(rf"(?:test_)?((?:{ROW}_)+)", name)
    return carried.group(1).strip("_").split("_") if carried else []


def is_of_the_contract(suite):
    """The papers' errata are numbered in the same way."""
    return suite != "Errata"


def figure_of(case):
    """What a test says that it measured; GoogleTest writes it as an attribute, or as an element."""
    said = {part.get("name"): part.get("value") for part in case.iter("property")}
    return case.get("figure") or said.get("figure")


def merged(figures):
    """Figures that say the same, as those of a test with parameters do, as one: numbers that differ become their range."""
    groups = {}
    for figure in figures:
        groups.setdefault(NUMBER.sub("#", figure), []).append(NUMBER.findall(figure))
    texts = []
    for template, numbers in groups.items():
        ranges = []
        for values in zip(*numbers):
            low, high = min(values, key=float), max(values, key=float)
            ranges.append(low if low == high else f"{low} to {high}")
        parts = iter(ranges)
        texts.append(re.sub("#", lambda _, parts=parts: next(parts), template))
    return "; ".join(texts)


class Test:
    """One test, with whatever parameters it has run."""

    def __init__(self):
        self.outcomes = Counter()
        self.figures = []

    def add(self, case):
        """Counts a result."""
        self.outcomes[summarise.outcome(case)] += 1
        if figure_of(case):
            self.figures.append(figure_of(case))


def binary_of(path):
    """gtest-x_test.xml, rosunit-x.xml and python-x.xml by the name that one runs them by."""
    kind, _, name = path.stem.partition("-")
    return f"{name}.test" if kind == "rosunit" else name


def collect(folder):
    """{row: {(binary, name): Test}} of every result file."""
    rows = {}
    for path in sorted(pathlib.Path(folder).rglob("*.xml")):
        for _, case in summarise.cases(path):
            if not is_of_the_contract(case.get("classname", "").split("/")[-1].split(".")[-1]):
                continue
            name = re.split(r"[/ ]", case.get("name", ""))[0]
            for row in rows_of(name):
                rows.setdefault(row, {}).setdefault((binary_of(path), name), Test()).add(case)
    return rows


def result_of(tests):
    """How the tests of a row ended, in words."""
    if not tests:
        return "**no test has run**"
    count = sum((test.outcomes for test in tests.values()), Counter())
    words = [f"{count['passed']} passed"] if count["passed"] else []
    words += [f"**{count[bad]} {bad}**" for bad in ("failed", "skipped") if count[bad]]
    return ", ".join(words)


def names_of(tests):
    """The tests by binary, without the row that all of them carry."""
    binaries = {}
    for binary, name in tests:
        binaries.setdefault(binary, []).append(name.replace("test_", "", 1) if name.startswith("test_") else name)
    return "; ".join(f"{binary}: " + ", ".join(f"`{name}`" for name in names) for binary, names in binaries.items())


def table(rows, results):
    """The lines of the table."""
    lines = ["| row | tests | result | figure |", "| --- | --- | --- | --- |"]
    for row in rows:
        tests = results.get(row, {})
        figures = merged([figure for test in tests.values() for figure in test.figures])
        lines.append(f"| {row} | {names_of(tests)} | {result_of(tests)} | {figures.replace('|', '/')} |")
    return lines


def with_table(page, lines):
    """The page with these lines between the markers."""
    if page.count(BEGIN) != 1 or page.count(END) != 1:
        raise ValueError(f"the page needs one line '{BEGIN}' and one '{END}'")
    before, rest = page.split(BEGIN)
    return "\n".join([before + BEGIN, "", *lines, "", END + rest.split(END)[1]])


def unproven(rows, results):
    """Rows without a test that passed, or with one that did not."""
    def proven(tests):
        outcomes = sum((test.outcomes for test in tests.values()), Counter())
        return outcomes["passed"] and not outcomes["failed"]
    return [row for row in rows if not proven(results.get(row, {}))]


def main():
    """Writes the table, where it has changed."""
    folder, path = sys.argv[1], pathlib.Path(sys.argv[2])
    page = path.read_text(encoding="utf-8")
    rows = contract_rows(page)
    results = collect(folder)
    written = with_table(page, table(rows, results))
    if written != page:
        path.write_text(written, encoding="utf-8")
    missing = unproven(rows, results)
    if missing:
        print(f"{path.name}: no test has shown {', '.join(missing)}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
