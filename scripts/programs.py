"""The package's programs, run as a user runs them."""

import pathlib
import subprocess


def run(folder, name, *arguments):
    """What a program of `folder` says; raises RuntimeError with that when it fails."""
    command = [str(pathlib.Path(folder) / name), *map(str, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}\n{done.stdout.strip()}")
    return done.stdout


def settings(values):
    """Words of the command line that set parameters {path: value}."""
    return [word for path, value in values.items() for word in ("--set", f"{path}={value}")]
