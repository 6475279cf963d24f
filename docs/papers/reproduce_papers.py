#!/usr/bin/python3
"""Reproduces the experiments of both papers with the package's tools: pictures, CSV and the tables of README.md."""

import argparse
import pathlib
import shutil
import sys
import tempfile

import figure4
import figures5to8
import rectangle
from package import Package

HERE = pathlib.Path(__file__).resolve().parent


def parse_arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tools", required=True, metavar="DIR", help="where the package's tools are")
    parser.add_argument("--output", default=HERE, type=pathlib.Path, metavar="DIR", help="default: %(default)s")
    parser.add_argument("--runs", default=20000, type=int, metavar="N", help="simulated robots (default: %(default)s)")
    return parser.parse_args()


def main():
    """Runs both."""
    arguments = parse_arguments()
    arguments.output.mkdir(parents=True, exist_ok=True)
    page = arguments.output / "README.md"
    if not page.exists():
        shutil.copy(HERE / "README.md", page)
    with tempfile.TemporaryDirectory() as folder:
        tools = Package(arguments.tools, folder)
        try:
            figure4.reproduce(tools, arguments.output, page)
            figures5to8.reproduce(tools, arguments.output, page)
            rectangle.reproduce(tools, arguments.output, page, arguments.runs)
        except (OSError, RuntimeError, ValueError) as error:
            return f"reproduce_papers: {error}"
    print(f"pictures and tables: {arguments.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
