"""Paper 2: the rectangle of 10 x 4.5 m, every method against simulated robots."""

import pathlib
from dataclasses import dataclass

import numpy as np

import package
import results
from package import trajectory
from results import plt

CONFIG = pathlib.Path(__file__).resolve().parent / "paper2_robot.yaml"
TRACK = 0.4        # m, as in CONFIG
TICK = 1e-6        # m, as in CONFIG
NOISE = {"1 mm": 0.01, "3 mm": 0.03}  # a wheel and step of 0.01 m: as noise/wheel, m/sqrt(m)
SEED = 2007
# Instants of the drive, as share of a leg: name, leg (from 0), share.
INSTANTS = (("end of the second leg", 1, 1.0), ("half of the third", 2, 0.5), ("end of the third", 2, 1.0),
            ("half of the last", 3, 0.5), ("end", 3, 1.0))
LEGS = (10.0, 4.5, 10.0, 4.5)


@dataclass
class Method:
    """One value of odometry/uncertainty."""

    name: str
    label: str
    style: dict


METHODS = (
    Method("first_order", "first order (S1), \"EKF\"", {"color": results.BLUE, "linestyle": "--"}),
    Method("exact_moments", "exact moments (S4')", {"color": results.GREEN}),
    Method("closed_form", "closed form with cross terms (S3)", {"color": results.PURPLE, "linestyle": "-."}),
    Method("monte_carlo", "particles (5'), about their mean", {"color": results.ORANGE, "linestyle": ":"}),
    Method("paper2_simplified", "paper 2, simplified (S2)", {"color": results.RED}),
)


@dataclass
class Experiment:
    """Standard deviations along the drive, for one level of noise."""

    distance: np.ndarray   # driven [m], n
    sigmas: dict           # method -> published standard deviations of x [m], y [m], yaw [rad], n x 3
    errors: np.ndarray     # of the simulated robots, from where their readings put them: root mean square, n x 3
    spread: np.ndarray     # of the simulated robots about their own mean: standard deviations, n x 3
    clouds: dict           # instant -> positions of simulated robots, runs x 2
    covariances: dict      # instant -> covariance by exact_moments


class Robots:
    """Robots that drive the same ticks, each with errors of its own: nothing is linearised here, and none of
    the package's code takes part."""

    def __init__(self, ticks, noise, runs):
        self._travels = np.diff(np.array(ticks, dtype=float), axis=0) * TICK
        self._noise = noise
        self._poses = np.zeros((3, runs))
        self._random = np.random.RandomState(SEED)  # its draws are the same in every version of numpy

    def drive(self, keep):
        """Means and standard deviations after every message, n x 3, and the positions after those in `keep`."""
        x, y, yaw = self._poses
        means, sigmas, clouds = [np.zeros(3)], [np.zeros(3)], {}
        for number, travel in enumerate(self._travels, start=1):
            draws = self._random.standard_normal((2, yaw.size))
            right, left = travel[:, None] + draws * (self._noise * np.sqrt(np.abs(travel)))[:, None]
            turn = (right - left) / TRACK
            x += 0.5 * (right + left) * np.cos(yaw + 0.5 * turn)
            y += 0.5 * (right + left) * np.sin(yaw + 0.5 * turn)
            yaw += turn
            means.append(self._poses.mean(axis=1))
            sigmas.append(self._poses.std(axis=1))
            if number in keep:
                clouds[number] = self._poses[:2].T.copy()
        return np.array(means), np.array(sigmas), clouds


def instants(truth):
    """Index of the message at each of INSTANTS."""
    driven = driven_distance(truth)
    ends = np.cumsum((0.0,) + LEGS)
    wanted = [ends[leg] + share * LEGS[leg] for _, leg, share in INSTANTS]
    return [int(np.searchsorted(driven, distance - 1e-4)) for distance in wanted]


def driven_distance(path):
    """Along the path [m], a value for each pose."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path.poses[:, :2], axis=0).T))])


def measure(tools, runs):
    """The experiment at every level of noise, and one drive as the paper's robot might have done it."""
    bag = tools.simulate("rectangle", "rectangle", CONFIG, "--rate", "20", "--noise-free")
    truth = package.truth_of(bag)
    ticks = package.rear_ticks(bag)
    keep = instants(truth)
    experiments = {}
    for name, noise in NOISE.items():
        paths = {method.name: tools.replay(bag, CONFIG, {"odometry/uncertainty": method.name, "noise/wheel": noise})
                 for method in METHODS}
        sigmas = {key: np.sqrt(np.diagonal(path.covariances, axis1=1, axis2=2)) for key, path in paths.items()}
        means, spread, clouds = Robots(ticks, noise, runs).drive(keep)
        errors = np.hypot(spread, means - paths["first_order"].poses)
        covariances = {index: paths["exact_moments"].covariances[index] for index in keep}
        experiments[name] = Experiment(driven_distance(truth), sigmas, errors, spread, clouds, covariances)
    # Gains drawn from a p(A) of no width: those of the file, so that noise is the only error.
    noisy = tools.simulate("one_drive", "rectangle", CONFIG, "--rate", "20", "--seed", str(SEED), "--draw-gains")
    return truth, experiments, (package.truth_of(noisy), tools.replay(noisy, CONFIG, {}))


def mark_legs(axes):
    """The corners as lines, the direction of each leg above."""
    ends = np.cumsum((0.0,) + LEGS)
    for end in ends[1:-1]:
        axes.axvline(end, color="black", linewidth=0.6, alpha=0.4)
    for begin, end, arrow in zip(ends, ends[1:], ("+x", "+y", "-x", "-y")):
        axes.text(0.5 * (begin + end), 1.0, arrow, transform=axes.get_xaxis_transform(), ha="center", va="bottom",
                  color="0.35", fontsize=9)
    axes.set_xlim(0.0, ends[-1])


def draw_simulation(axes, experiment, index):
    """The judge."""
    axes.plot(experiment.distance, experiment.errors[:, index], color=results.GREY, linewidth=5, alpha=0.6,
              label="simulated robots")


def draw_methods(experiments, path):
    """Standard deviations of x and y along the drive: a row for each coordinate, a column for each noise."""
    figure, grid = plt.subplots(2, len(experiments), figsize=(9, 6.4), sharex=True)
    for column, (noise, experiment) in zip(grid.T, experiments.items()):
        for axes, coordinate, index in zip(column, "xy", (0, 1)):
            draw_simulation(axes, experiment, index)
            for method in METHODS:
                axes.plot(experiment.distance, experiment.sigmas[method.name][:, index], linewidth=1.5,
                          label=method.label, **method.style)
            mark_legs(axes)
            axes.set_ylim(bottom=0.0)
            axes.set_ylabel(f"standard deviation of {coordinate} [m]")
        column[0].set_title(f"{noise} of noise a wheel and step", pad=18)
        column[1].set_xlabel("distance driven [m]")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, frameon=False)
    figure.tight_layout(rect=(0.0, 0.08, 1.0, 1.0))
    results.save(figure, path)


def draw_figures_4_to_7(experiment, path):
    """The paper's figures 4 to 7, each against simulated robots."""
    figure, grid = plt.subplots(2, 2, figsize=(9, 6), sharex=True, sharey=True)
    panels = (("4", "paper2_simplified", 0), ("5", "paper2_simplified", 1), ("6", "first_order", 0),
              ("7", "first_order", 1))
    names = {"paper2_simplified": "the paper's method", "first_order": "Kalman filter"}
    methods = {method.name: method for method in METHODS}
    for axes, (number, name, index) in zip(grid.flat, panels):
        draw_simulation(axes, experiment, index)
        axes.plot(experiment.distance, experiment.sigmas[name][:, index], linewidth=1.8,
                  **{**methods[name].style, "linestyle": "-"}, label=methods[name].label)
        mark_legs(axes)
        axes.set_title(f"Figure {number}: {'xy'[index]}, {names[name]}", pad=16)
        axes.set_ylim(0.0, 1.75)
        axes.legend(loc="upper left", frameon=False)
    for axes in grid[:, 0]:
        axes.set_ylabel("standard deviation [m]")
    for axes in grid[1]:
        axes.set_xlabel("distance driven [m]")
    figure.tight_layout()
    results.save(figure, path)


def draw_one_drive(axes, truth, one_drive):
    """The paper's figure 3."""
    axes.plot(*truth.poses[:, :2].T, color=results.GREY, linewidth=4, alpha=0.6, label="true path")
    axes.plot(*one_drive.poses[:, :2].T, color=results.BLUE, linewidth=1.5, label="odometry")
    axes.plot(*one_drive.poses[0, :2], "ks", markersize=5, label="start")
    axes.plot(*one_drive.poses[-1, :2], "o", color=results.BLUE, markersize=6, label="end of the odometry")
    axes.set_title("Figure 3: one drive")


def draw_clouds(axes, truth, experiment):
    """Where robots are that started alike."""
    axes.plot(*truth.poses[:, :2].T, color=results.GREY, linewidth=4, alpha=0.6)
    colours = (results.PURPLE, results.GREEN, results.ORANGE, results.BLUE)
    for (name, _, _), index, colour in zip(INSTANTS, experiment.clouds, colours):
        covariance = experiment.covariances[index]
        axes.plot(*experiment.clouds[index][:300].T, ".", color=colour, markersize=2.0, alpha=0.5)
        outline = trajectory.ellipse(truth.poses[index], covariance, 2.0)
        sigma_x, sigma_y = np.sqrt(np.diag(covariance)[:2])
        axes.plot(*outline.T, color=colour, linewidth=2.0,
                  label=f"{name}:\n$\\sigma_x$ = {sigma_x:.2f} m, $\\sigma_y$ = {sigma_y:.2f} m")
    axes.set_title("300 robots at four instants, 2 sigma ellipses")


def draw_paths(truth, experiment, one_drive, path):
    """The paper's figure 3, and why variances shrink."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.9), sharey=True)
    draw_one_drive(left, truth, one_drive)
    draw_clouds(right, truth, experiment)
    for axes in (left, right):
        axes.set_xlim(-2.5, 12.5)
        axes.set_ylim(-2.5, 9.5)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncol=2, frameon=False)
    left.set_ylabel("y [m]")
    figure.tight_layout()
    results.save(figure, path)


def table_of_ends(experiments):
    """Standard deviations at the end, and the largest fall of a variance."""
    head = ["method"] + [f"{noise}: sigma x, y [m]" for noise in experiments] + ["1 mm: largest fall of Var x, Var y"]
    fine = next(iter(experiments.values()))
    columns = [(method.label, lambda e, name=method.name: e.sigmas[name]) for method in METHODS]
    rows = []
    judges = [("simulated robots, error of the dead-reckoned pose", lambda e: e.errors),
              ("simulated robots, about their mean", lambda e: e.spread)]
    for label, sigmas in judges + columns:
        ends = [f"{sigmas(e)[-1, 0]:.3f}, {sigmas(e)[-1, 1]:.3f}" for e in experiments.values()]
        falls = [f"{100.0 * largest_fall(sigmas(fine)[:, index] ** 2):.0f} %" for index in (0, 1)]
        rows.append([label] + ends + [", ".join(falls)])
    return results.markdown_table(head, rows)


def largest_fall(variances):
    """Of a variance below an earlier value of itself, as a share of that value."""
    highest = np.maximum.accumulate(variances)
    return float(np.max(1.0 - variances[1:] / highest[1:]))


def table_of_instants(truth, experiment):
    """Standard deviations on the return legs."""
    head = ["", "driven [m]", "simulated robots: x, y [m]", "exact moments", "first order", "paper 2, simplified"]
    rows = []
    for (name, _, _), index in zip(INSTANTS, instants(truth)):
        columns = [experiment.errors] + [experiment.sigmas[key]
                                            for key in ("exact_moments", "first_order", "paper2_simplified")]
        rows.append([name, f"{experiment.distance[index]:.2f}"]
                    + [f"{values[index, 0]:.3f}, {values[index, 1]:.3f}" for values in columns])
    return results.markdown_table(head, rows)


def write_sigmas(experiment, path):
    """Standard deviations along the drive, every 16th message."""
    sigmas_of = {"simulated": experiment.errors, "simulated_spread": experiment.spread, **experiment.sigmas}
    columns = {"distance": experiment.distance[::16]}
    for name, sigmas in sigmas_of.items():
        for coordinate, values in zip(("x", "y", "yaw"), sigmas.T):
            columns[f"{name}_{coordinate}"] = values[::16]
    results.write_csv(path, columns)


def reproduce(tools, output, page, runs):
    """Everything about paper 2."""
    truth, experiments, (true_drive, one_drive) = measure(tools, runs)
    fine = experiments["1 mm"]
    draw_methods(experiments, output / "paper2_methods.png")
    draw_figures_4_to_7(fine, output / "paper2_figures_4_to_7.png")
    draw_paths(true_drive, fine, one_drive, output / "paper2_paths.png")
    for noise, experiment in experiments.items():
        write_sigmas(experiment, output / f"paper2_sigmas_{noise.replace(' ', '')}.csv")
    results.put_table(page, "ends", table_of_ends(experiments))
    results.put_table(page, "instants", table_of_instants(truth, fine))
