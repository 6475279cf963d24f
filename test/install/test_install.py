#!/usr/bin/python3
"""`cmake --install` into an empty folder gives a package that runs from there alone.

Where the system allows it, source and build folder are hidden while the installed package runs: an empty file
system is mounted over them, seen by the package's processes only.
"""

import os
import pathlib
import shlex
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "support"))
import xunit  # noqa: E402
from ros_session import free_port  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BS_CAR_ODOMETRY_BUILD", ROOT / ".work/build"))
DEVEL = pathlib.Path(os.environ.get("BS_CAR_ODOMETRY_DEVEL", ROOT / ".work/devel"))
ROS_SETUP = "/opt/ros/noetic/setup.bash"


def can_hide():
    """Whether this user may mount something that only its own processes see."""
    trial = ["unshare", "--mount", "--map-root-user", "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(trial, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0


class Install(unittest.TestCase):
    """The installed package, with a shell that knows nothing but its setup file."""

    @classmethod
    def setUpClass(cls):
        """Installs once."""
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.home = pathlib.Path(cls.folder.name)
        # Not --prefix: catkin's setup files go to the prefix that was configured whatever it says.
        subprocess.run(["cmake", "--install", BUILD], check=True, stdout=subprocess.DEVNULL,
                       env=dict(os.environ, DESTDIR=str(cls.home / "root")))
        cls.prefix = next((cls.home / "root").rglob("setup.bash")).parent

    def run_installed(self, script):
        """Output of a shell script that ran with nothing but the installed package."""
        # The source last: the other two may lie inside it.
        hide = "".join(f"mount -t tmpfs none {shlex.quote(str(path))}\n" for path in (BUILD, DEVEL, ROOT)
                       if can_hide())
        ros = f"source {ROS_SETUP}\n" if os.path.exists(ROS_SETUP) else ""
        lines = f"cd {self.home}\nset -e\n{hide}{ros}source {self.prefix}/setup.bash\n{script}\n"
        shell = [*(["unshare", "--mount", "--map-root-user"] if hide else []), "bash", "-c", lines]
        environment = {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": str(self.home), "ROS_IP": "127.0.0.1"}
        done = subprocess.run(shell, env=environment, text=True, check=False, timeout=300,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def test_is_found_where_it_was_installed(self):
        """rospack finds no other copy."""
        self.assertEqual(self.run_installed("rospack find bs_car_odometry").strip().splitlines()[-1],
                         str(self.prefix / "share/bs_car_odometry"))

    def test_no_file_mentions_the_source(self):
        """Neither texts nor library paths lead back to where it was built."""
        for path in (ROOT, BUILD, DEVEL):
            found = subprocess.run(["grep", "-rIlF", str(path), self.prefix], text=True, check=False,
                                   stdout=subprocess.PIPE).stdout
            self.assertEqual(found, "")

    def test_programs_find_their_libraries(self):
        """ldd resolves every library of every program and plugin, to the install space or the system."""
        self.assertNotIn("not found", self.run_installed(
            f"for f in {self.prefix}/lib/bs_car_odometry/* {self.prefix}/lib/*.so; do ldd $f 2>/dev/null || true; done"))

    def test_tools_run(self):
        """simulate, replay_bag, plot_odometry and consistency from the install space, with an installed vehicle file."""
        output = self.run_installed("""
            config=$(rospack find bs_car_odometry)/config/cycab.yaml
            rosrun bs_car_odometry simulate --scenario circle --config $config --output drive.bag
            rosrun bs_car_odometry replay_bag drive.bag --config $config --output odometry.bag
            rosrun bs_car_odometry plot_odometry odometry.bag --truth drive.bag --output path.png
            rosrun bs_car_odometry consistency --scenario fig4 --config $config --runs 10 --picture nees.png""")
        self.assertIn("end drift", output)
        self.assertIn("| fig4 | ackermann | both |", output)
        for picture in ("path.png", "nees.png"):
            self.assertGreater((self.home / picture).stat().st_size, 10000)

    def test_demo_launch_runs(self):
        """roslaunch finds the nodelet, the simulated car, the vehicle file, and the drive is recorded."""
        self.run_installed(f"""
            roslaunch -p {free_port()} bs_car_odometry demo.launch rviz:=false scenario:=fig4 record:={self.home}/demo.bag
            rosrun bs_car_odometry plot_odometry demo.bag""")
        self.assertTrue((self.home / "demo.bag").exists())


if __name__ == "__main__":
    xunit.main("install")
