"""ROS programs of a test: a free port for the master, processes that are ended whatever happens."""

import contextlib
import os
import signal
import socket
import subprocess


def free_port():
    """A TCP port that nobody uses."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


@contextlib.contextmanager
def running(command, **options):
    """The process of a command; interrupted at the end as by Ctrl-C, which is how roslaunch ends its nodes."""
    process = subprocess.Popen(command, start_new_session=True, **options)  # pylint: disable=consider-using-with
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.wait(timeout=30)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
