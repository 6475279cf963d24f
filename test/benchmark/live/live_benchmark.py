#!/usr/bin/env python3
"""live_latency under a master of its own: live_benchmark.py PROGRAM [MESSAGES [RUNS [RATE ...]]]"""

import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../support"))
import ros_session  # noqa: E402 pylint: disable=wrong-import-position


def main():
    """Runs it; its exit status is 0 for a pass."""
    port = str(ros_session.free_port())
    environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    environment.pop("ROS_HOSTNAME", None)
    with ros_session.running(["roscore", "-p", port], env=environment, stdout=subprocess.DEVNULL):
        waiting = "until rosparam list >/dev/null 2>&1; do sleep 0.2; done"
        subprocess.check_call(["timeout", "30", "bash", "-c", waiting], env=environment)
        return subprocess.call(sys.argv[1:], env=environment)


if __name__ == "__main__":
    sys.exit(main())
