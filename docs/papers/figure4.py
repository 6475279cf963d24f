"""Paper 1, figure 4: "Odometry 1" and "Odometry 2" over the same drive."""

from dataclasses import dataclass

import numpy as np

import package
import results
from results import plt

CONFIG = package.ROOT / "config/cycab.yaml"
TICK = 1e-4  # m, of the encoders: the truth is not known better
BEND = 5.2  # s: the steering begins to turn
CARS = {
    "gains known, no noise": ["--noise-free"],
    "gains 2, -1, 3 % off, noise": ["--seed", "1"],
}


@dataclass
class Trace:
    """One odometry."""

    label: str
    settings: dict
    style: dict


REAR = {"odometry/axles": "rear"}
PAPER = {**REAR, "odometry/motion": "paper"}
TRACES = (
    Trace("Odometry 1: model (2)", PAPER, {"color": results.BLUE, "linestyle": "--"}),
    Trace("Odometry 2: B in place of B cos(alpha)", {**PAPER, "odometry/shortened_track": "false"},
          {"color": results.RED, "linestyle": "-."}),
    Trace("this package, rear axle", REAR, {"color": results.PURPLE, "linestyle": ":"}),
    Trace("this package, all wheels", {"odometry/axles": "both"}, {"color": results.GREEN}),
)


@dataclass
class Drive:
    """Truth and traces."""

    truth: package.trajectory.Trajectory
    traces: list

    def errors(self):
        """Distance of every trace from the truth [m], each n."""
        return [np.hypot(*package.trajectory.compare(trace, self.truth).differences[:, :2].T) for trace in self.traces]


def measure(tools):
    """The drive of the figure with every car of CARS."""
    drives = {}
    for number, (name, options) in enumerate(CARS.items()):
        bag = tools.simulate(f"fig4_{number}", "fig4", CONFIG, *options)
        drives[name] = Drive(package.truth_of(bag), [tools.replay(bag, CONFIG, trace.settings) for trace in TRACES])
    return drives


def draw(drives, path):
    """A row for each car: paths, and how far they have been from the truth."""
    figure, grid = plt.subplots(len(drives), 2, figsize=(9, 8.4), gridspec_kw={"width_ratios": [1.0, 1.1]})
    for (plan, over_time), (name, drive) in zip(grid, drives.items()):
        plan.plot(*drive.truth.poses[:, :2].T, color=results.GREY, linewidth=5, alpha=0.6, label="truth")
        for trace, path_of, error in zip(TRACES, drive.traces, drive.errors()):
            plan.plot(*path_of.poses[:, :2].T, linewidth=1.6, label=trace.label, **trace.style)
            over_time.semilogy(path_of.stamps - path_of.stamps[0], np.maximum.accumulate(error), linewidth=1.6,
                               **trace.style)
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_title(name)
        plan.set_xlabel("x [m]")
        plan.set_ylabel("y [m]")
        over_time.set_xlabel("time [s]")
        over_time.set_ylabel("largest distance from the truth so far [m]")
        over_time.set_ylim(1e-5, 10.0)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, frameon=False)
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    results.save(figure, path)


def table_of_errors(drives):
    """Distance from the truth before the bend, at BEND, and at the end."""
    head = ["odometry"] + [f"{name}: {when}" for name in drives for when in ("before the bend", "at the end")]
    rows = []
    for number, trace in enumerate(TRACES):
        row = [trace.label]
        for drive in drives.values():
            stamps = drive.traces[number].stamps
            bend = int(np.searchsorted(stamps, stamps[0] + BEND))
            error = drive.errors()[number]
            row += [metres(error[bend]), metres(error[-1])]
        rows.append(row)
    return results.markdown_table(head, rows)


def metres(value):
    """A distance in the unit that suits it."""
    if value < TICK:
        return "< 0.1 mm"
    if value < 0.01:
        return f"{1e3 * value:.1f} mm"
    return f"{1e2 * value:.1f} cm" if value < 0.1 else f"{value:.2f} m"


def write_traces(drive, path):
    """Positions over time, every fifth message."""
    stamps = drive.traces[0].stamps
    columns = {"time": stamps[::5] - stamps[0]}
    truth = drive.truth.at(stamps)
    names = ["truth", "odometry_1", "odometry_2", "rear_axle", "all_wheels"]
    for name, poses in zip(names, [truth] + [trace.poses for trace in drive.traces]):
        columns[f"{name}_x"], columns[f"{name}_y"] = poses[::5, 0], poses[::5, 1]
    results.write_csv(path, columns)


def reproduce(tools, output, page):
    """Everything about paper 1."""
    drives = measure(tools)
    draw(drives, output / "paper1_figure_4.png")
    for name, file in zip(drives, ("paper1_noise_free.csv", "paper1_uncalibrated.csv")):
        write_traces(drives[name], output / file)
    results.put_table(page, "figure 4", table_of_errors(drives))
