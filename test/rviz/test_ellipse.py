#!/usr/bin/python3
"""rviz/odometry.rviz shows the covariance ellipse: seen in a screenshot of rviz without a display of its own.

A simulated drive is replayed through replay.launch. The ellipse's colour must cover the car, and must not when
the covariance is switched off in the same rviz file: the check can fail.
"""

import contextlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import matplotlib.image
import numpy as np
import yaml

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "support"))
import xunit  # noqa: E402
from ros_session import free_port, running  # noqa: E402

TOOLS = pathlib.Path(os.environ.get("BS_CAR_ODOMETRY_TOOLS", ROOT / ".work/devel/lib/bs_car_odometry"))
PICTURES = pathlib.Path(os.environ.get("BS_CAR_ODOMETRY_PICTURES", tempfile.gettempdir()))
CONFIG = ROOT / "config/cycab.yaml"
RVIZ_FILE = ROOT / "rviz/odometry.rviz"
SCREEN = "1200x800x24"
PLAYED = "] process has finished cleanly"  # what roslaunch says of the player
NEAR = 60  # pixels on each side of the middle, where the view keeps the car


@contextlib.contextmanager
def virtual_display():
    """An X server without a screen, on a display number that it chooses itself."""
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", SCREEN, "-nolisten", "tcp"]
    with running(command, pass_fds=[write_end], stderr=subprocess.DEVNULL):
        os.close(write_end)
        with os.fdopen(read_end) as number:
            yield f":{number.readline().strip()}"


def simulate(bag):
    """A drive with noise, long enough for a large ellipse."""
    subprocess.run([TOOLS / "simulate", "--scenario", "slalom_eight", "--config", CONFIG, "--output", bag],
                   check=True, stdout=subprocess.DEVNULL)


def without_panels(rviz, covariance):
    """The rviz file with nothing but the drawing, and the covariance on or off."""
    rviz["Window Geometry"] = {"Width": 1200, "Height": 800, "Hide Left Dock": True, "Hide Right Dock": True}
    rviz["Panels"] = []
    manager = rviz["Visualization Manager"]
    for display in manager["Displays"]:
        if display["Name"] == "Odometry":
            display["Covariance"]["Value"] = covariance
    return rviz


def wait_until(condition, seconds=120.0):
    """Returns when the condition holds, or after that time."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.2)


def ellipse_pixels(picture):
    """How many pixels near the middle are purple: more red and blue than green."""
    image = matplotlib.image.imread(picture)[:, :, :3]
    rows, columns = image.shape[0] // 2, image.shape[1] // 2
    middle = image[rows - NEAR:rows + NEAR, columns - NEAR:columns + NEAR]
    red, green, blue = np.moveaxis(middle, 2, 0)
    return int(np.sum((red > green + 0.1) & (blue > green + 0.1)))


@unittest.skipUnless(shutil.which("rviz") and shutil.which("Xvfb") and shutil.which("import"),
                     "needs rviz, Xvfb and ImageMagick")
class Ellipse(unittest.TestCase):
    """Screenshots at the end of a replayed drive."""

    def screenshot(self, covariance):
        """Simulates a drive, replays it faster than it was driven, and takes the picture at its end."""
        with tempfile.TemporaryDirectory() as folder, virtual_display() as display:
            folder = pathlib.Path(folder)
            simulate(folder / "drive.bag")
            rviz_file = folder / "odometry.rviz"
            rviz_file.write_text(yaml.safe_dump(without_panels(yaml.safe_load(RVIZ_FILE.read_text()), covariance)))
            picture = PICTURES / f"ellipse_{'on' if covariance else 'off'}.png"
            self.replay(folder / "drive.bag", rviz_file, display, picture)
        return picture

    def replay(self, bag, rviz_file, display, picture):
        """Runs replay.launch on that display; the picture is taken when the bag has ended."""
        environment = dict(os.environ, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1",
                           PYTHONUNBUFFERED="1")  # roslaunch's log is read while it runs
        launch = ["roslaunch", "-p", str(free_port()), "bs_car_odometry", "replay.launch", f"bag:={bag}",
                  f"config:={CONFIG}", "rate:=4", "rviz:=true", f"rviz_config:={rviz_file}"]
        log = picture.with_suffix(".log")
        with open(log, "w") as output, running(launch, env=environment, stdout=output, stderr=output) as process:
            wait_until(lambda: PLAYED in log.read_text() or process.poll() is not None)
            self.assertIn(PLAYED, log.read_text())
            self.assertIsNone(process.poll(), log.read_text())
            time.sleep(2.0)  # rviz draws the last messages
            subprocess.run(["import", "-window", "root", picture], env=environment, check=True)

    def test_O5_covers_the_car(self):
        """The ellipse of 3 sigma after 60 m is larger than the arrow of the car."""
        self.assertGreater(ellipse_pixels(self.screenshot(covariance=True)), 1000)

    def test_O5_check_can_fail(self):
        """Nothing else in the picture has the ellipse's colour."""
        self.assertLess(ellipse_pixels(self.screenshot(covariance=False)), 100)


if __name__ == "__main__":
    xunit.main("rviz")
