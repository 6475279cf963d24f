"""Paper 1, figures 5 to 8: k_d on a straight run, k_r and k_b on the drive of figure 4, the path before and after."""

from dataclasses import dataclass

import numpy as np

import package
import results
from figure4 import CONFIG, PAPER, REAR, metres
from results import plt

TRUE = {"k_r": 1.02, "k_l": 0.99, "k_b": 1.03}  # of the simulated car
# Both wheels go as far on a straight run: their pulses, and with them their weights in k_d, go as 1/k.
TRUE["k_d"] = 2.0 * TRUE["k_r"] * TRUE["k_l"] / (TRUE["k_r"] + TRUE["k_l"])
GAINS = ("k_r", "k_l", "k_b")
SIGMAS = 3.0
LASER = ("--laser-rate", "10")
WHEEL = 0.005  # noise/wheel [m/sqrt(m)]


@dataclass
class Method:
    """A way to calibrate, and the odometry that it is for."""

    label: str
    settings: dict
    style: dict


METHODS = {
    "paper": Method("paper, model (2)", {**PAPER, "calibration/method": "paper"},
                    {"color": results.BLUE, "linestyle": "--"}),
    "joint": Method("joint, rear axle", {**REAR, "calibration/method": "joint"}, {"color": results.GREEN}),
}


@dataclass
class Calibration:
    """What a filter has believed, a row for each laser pose; the straight run and the drive of figure 4."""

    straight: dict
    bend: dict

    def gains(self):
        """Name -> value and standard deviation at the end."""
        return {name: (self.bend[f"rear/{name}"][-1], self.bend[f"rear/{name}_std"][-1]) for name in GAINS}

    def distance_gain(self):
        """The same of k_d."""
        return self.bend["k_d_rear"][-1], self.bend["k_d_rear_std"][-1]


@dataclass
class Drive:
    """A drive of figure 4 and the odometry over it."""

    truth: package.trajectory.Trajectory
    before: package.trajectory.Trajectory
    after: dict  # method -> trajectory

    def error(self, trace):
        """Distance from the truth [m], n."""
        return np.hypot(*package.trajectory.compare(trace, self.truth).differences[:, :2].T)


def split(updates, beginning):
    """The rows before a stamp and those from it on, with the time since their beginning."""
    before = updates["stamp"] < beginning
    parts = []
    for rows, start in ((before, updates["stamp"][0]), (~before, beginning)):
        part = {name: values[rows] for name, values in updates.items()}
        part["time"] = part["stamp"] - start
        parts.append(part)
    return parts


def calibrate(tools, straight, bend):
    """Both methods over both bags."""
    beginning = package.truth_of(bend).stamps[0]
    return {name: Calibration(*split(tools.calibrate(name, [straight, bend], CONFIG, method.settings), beginning))
            for name, method in METHODS.items()}


def measure(tools):
    """A straight run and the drive of figure 4 for the calibration, and a drive that it has not seen."""
    straight = tools.simulate("straight", "straight", CONFIG, "--seed", "1", *LASER)
    bend = tools.simulate("bend", "fig4", CONFIG, "--seed", "2", "--start-time", "1600000100", *LASER)
    calibrations = calibrate(tools, straight, bend)
    other = tools.simulate("other", "fig4", CONFIG, "--seed", "3")
    return calibrations, [replayed(tools, bag, calibrations) for bag in (bend, other)]


def replayed(tools, bag, calibrations):
    """The odometry over a drive, with the gains of nobody and of each method."""
    after = {}
    for name, calibration in calibrations.items():
        gains = {f"gains/rear/{gain}": value for gain, (value, _) in calibration.gains().items()}
        after[name] = tools.replay(bag, CONFIG, {**odometry_of(name), **gains})
    return Drive(package.truth_of(bag), tools.replay(bag, CONFIG, PAPER), after)


def odometry_of(name):
    """Settings of a method that the odometry has."""
    return {path: value for path, value in METHODS[name].settings.items() if path.startswith("odometry/")}


def draw_gain(axes, place, value, deviation, method):
    """A gain with its band."""
    axes.fill_between(place, value - SIGMAS * deviation, value + SIGMAS * deviation, color=method.style["color"],
                      alpha=0.18, linewidth=0)
    axes.plot(place, value, linewidth=1.6, label=method.label, **method.style)


def draw_truth(axes, name, place):
    """The gain of the simulated car, and what the panel shows."""
    axes.axhline(TRUE[name], color="black", linewidth=0.9, linestyle=":", label="truth")
    axes.set_xlabel(place)
    axes.set_ylabel(name)


def draw_gains(calibrations, path):
    """Figures 5, 6 and 7."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.9))
    straight = calibrations["paper"].straight
    draw_gain(left, straight["distance"], straight["k_d_rear"], straight["k_d_rear_std"], METHODS["paper"])
    draw_truth(left, "k_d", "distance driven [m]")
    left.set_title("Figure 5: straight run")
    left.set_ylim(TRUE["k_d"] - 0.02, TRUE["k_d"] + 0.02)
    for axes, number, name, span in ((middle, 6, "k_r", 0.03), (right, 7, "k_b", 0.16)):
        for key, calibration in calibrations.items():
            bend = calibration.bend
            draw_gain(axes, bend["time"], bend[f"rear/{name}"], bend[f"rear/{name}_std"], METHODS[key])
        draw_truth(axes, name, "time [s]")
        axes.set_title(f"Figure {number}: drive of figure 4")
        axes.set_ylim(TRUE[name] - span, TRUE[name] + span)
    handles, labels = middle.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, frameon=False)
    figure.tight_layout(rect=(0.0, 0.08, 1.0, 1.0))
    results.save(figure, path)


def draw_paths(calibrations, drives, path):
    """Figure 8, and beside it how far each path has been from the truth."""
    figure, (plan, error) = plt.subplots(1, 2, figsize=(9, 4.6), gridspec_kw={"width_ratios": [1.0, 1.1]})
    bend, drive = calibrations["paper"].bend, drives[0]
    plan.plot(bend["laser_x"], bend["laser_y"], ".", color=results.GREY, markersize=5, label="laser")
    before = Method("model (2), not calibrated", {}, {"color": results.RED, "linestyle": "-."})
    traces = [(before, drive.before)] + [(METHODS[name], trace) for name, trace in drive.after.items()]
    for method, trace in traces:
        plan.plot(*trace.poses[:, :2].T, linewidth=1.6, label=method.label, **method.style)
        error.semilogy(trace.stamps - trace.stamps[0], np.maximum.accumulate(drive.error(trace)), linewidth=1.6,
                       **method.style)
    plan.set_aspect("equal", adjustable="datalim")
    plan.set_title("Figure 8")
    plan.set_xlabel("x [m]")
    plan.set_ylabel("y [m]")
    error.set_xlabel("time [s]")
    error.set_ylabel("largest distance from the truth so far [m]")
    error.set_ylim(1e-3, 10.0)
    handles, labels = plan.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=4, frameon=False)
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    results.save(figure, path)


def table_of_gains(calibrations):
    """Gains at the end, and how far they are from the truth."""
    rows = [["truth"] + [f"{TRUE[name]:.4f}" for name in ("k_d", *GAINS)]]
    for name, calibration in calibrations.items():
        found = {"k_d": calibration.distance_gain(), **calibration.gains()}
        rows.append([METHODS[name].label] + [f"{value:.4f} ± {deviation:.4f}" for value, deviation in found.values()])
    return results.markdown_table(["calibration", "k_d", *GAINS], rows)


def table_of_paths(drives):
    """Distance from the truth at the end of the drive of the calibration, and of one that it has not seen."""
    labels = ["not calibrated, model (2)"] + [METHODS[name].label for name in METHODS]
    ends = [[drive.error(trace)[-1] for trace in (drive.before, *drive.after.values())] for drive in drives]
    rows = [[label, *map(metres, errors)] for label, *errors in zip(labels, *ends)]
    return results.markdown_table(["odometry", "at the end of this drive", "at the end of another one"], rows)


def table_of_distances(calibration):
    """k_d on the way, and what a perfect laser would leave of its doubt."""
    rows = []
    for distance in (5.0, 10.0, 20.0):
        row = int(np.searchsorted(calibration.straight["distance"], distance - 0.02))
        row = min(row, len(calibration.straight["distance"]) - 1)
        value, deviation = (calibration.straight[f"k_d_rear{part}"][row] for part in ("", "_std"))
        rows.append([f"{distance:.0f} m", f"{value:.4f}", f"{deviation:.4f}", f"{WHEEL / np.sqrt(2.0 * distance):.4f}"])
    return results.markdown_table(["driven", "k_d", "standard deviation", "with a perfect laser"], rows)


def write_gains(calibrations, path):
    """The drive of figure 4, a row for each laser pose; k_d of the straight run is in a file of its own."""
    columns = {"time": calibrations["paper"].bend["time"]}
    for key, calibration in calibrations.items():
        for name in GAINS:
            columns[f"{key}_{name}"] = calibration.bend[f"rear/{name}"]
            columns[f"{key}_{name}_std"] = calibration.bend[f"rear/{name}_std"]
    results.write_csv(path, columns)


def reproduce(tools, output, page):
    """The calibration of paper 1."""
    calibrations, drives = measure(tools)
    straight = calibrations["paper"].straight
    draw_gains(calibrations, output / "paper1_figures_5_to_7.png")
    draw_paths(calibrations, drives, output / "paper1_figure_8.png")
    results.write_csv(output / "paper1_distance_gain.csv", {
        "distance": straight["distance"], "k_d": straight["k_d_rear"], "k_d_std": straight["k_d_rear_std"]})
    write_gains(calibrations, output / "paper1_gains.csv")
    results.put_table(page, "figure 5", table_of_distances(calibrations["paper"]))
    results.put_table(page, "figures 6 and 7", table_of_gains(calibrations))
    results.put_table(page, "figure 8", table_of_paths(drives))
