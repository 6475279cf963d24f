#!/usr/bin/env python3
"""Draws car.svg and car.png, the figure of docs/model.md: a bi-steerable car in a left turn, to scale.

Directions and turning centre are computed with (K2) and (K3), so the picture is an instance of the model.
Run it from anywhere; the output lands beside this script. Needs python3-matplotlib and python3-numpy.
"""
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc, Polygon

matplotlib.rcParams.update({"svg.hashsalt": "bs_car_odometry", "font.size": 11, "mathtext.fontset": "dejavusans"})

# The car of the picture [m, rad]; angles and hub offset larger than life.
A_F, A_R = 1.35, -1.60
TRACK, HUB = 1.60, 0.20
PHI_F, PHI_R = 0.46, -0.34
WHEEL_LENGTH, WHEEL_WIDTH = 0.62, 0.17

INK, BODY, STEER, CENTRE, FRAME, GHOST = "#222222", "#8a8f98", "#c0392b", "#2471a3", "#1e8449", "#b8bcc2"

L = A_F - A_R
KAPPA = (np.tan(PHI_F) - np.tan(PHI_R)) / L  # (K2)
BETA = (A_F * np.tan(PHI_R) - A_R * np.tan(PHI_F)) / L
ICR = np.array([-BETA / KAPPA, 1.0 / KAPPA])


def direction(x, y):
    """Ideal rolling direction of a wheel at (x, y), (K3)."""
    return np.arctan2(BETA + KAPPA * x, 1.0 - KAPPA * y)


def along(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def across(angle):
    return np.array([-np.sin(angle), np.cos(angle)])


def wheel(ax, centre, angle, **style):
    u, v = along(angle) * WHEEL_LENGTH / 2, across(angle) * WHEEL_WIDTH / 2
    ax.add_patch(Polygon([centre + u + v, centre + u - v, centre - u - v, centre - u + v], closed=True, **style))


def arrow(ax, start, end, colour, width=1.6, style="-|>"):
    ax.annotate("", xy=end, xytext=start,
                arrowprops=dict(arrowstyle=style, color=colour, lw=width, shrinkA=0, shrinkB=0, mutation_scale=13))


def label(ax, x, y, text, colour=INK, **style):
    style = {"ha": "center", "va": "center", **style}
    ax.text(x, y, text, color=colour, bbox=dict(facecolor="white", edgecolor="none", pad=0.8, alpha=0.85), zorder=9,
            **style)


def angle_arc(ax, centre, radius, start, end, colour):
    low, high = sorted((start, end))
    ax.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=np.degrees(low), theta2=np.degrees(high), color=colour,
                     lw=1.4))


def dimension(ax, start, end, text, offset=(0.0, 0.0)):
    arrow(ax, start, end, INK, 0.9, "<|-|>")
    middle = (np.array(start) + np.array(end)) / 2 + np.array(offset)
    label(ax, middle[0], middle[1], text)


def extension(ax, start, end):
    ax.plot([start[0], end[0]], [start[1], end[1]], color=INK, lw=0.5, ls=":")


def draw_car(ax):
    front, rear = np.array([A_F, 0.0]), np.array([A_R, 0.0])
    ax.add_patch(Polygon([(A_R - 0.45, 0.5), (A_F + 0.3, 0.5), (A_F + 0.55, 0.3), (A_F + 0.55, -0.3),
                          (A_F + 0.3, -0.5), (A_R - 0.45, -0.5)], closed=True, facecolor="#f4f5f7", edgecolor=GHOST,
                         lw=1.0, zorder=0))
    ax.plot([A_R - 0.75, A_F + 0.95], [0, 0], color=GHOST, lw=1.0, ls=(0, (8, 3, 2, 3)), zorder=1)

    for a, name in ((A_F, "f"), (A_R, "r")):
        ax.plot([a, a], [-(TRACK / 2 - HUB), TRACK / 2 - HUB], color=BODY, lw=3.0, zorder=1, solid_capstyle="round")
        for side in (1.0, -1.0):
            wheel(ax, np.array([a, side * TRACK / 2]), 0.0, facecolor="none", edgecolor=GHOST, lw=0.9, ls="--")
            kingpin = np.array([a, side * (TRACK / 2 - HUB)])
            delta = direction(*kingpin)
            contact = kingpin + side * HUB * across(delta)
            ax.plot(*np.array([kingpin, contact]).T, color=BODY, lw=3.0, zorder=2)
            wheel(ax, contact, delta, facecolor="#d9dce1", edgecolor=INK, lw=1.3, zorder=3)
            ax.plot(*kingpin, "o", color=INK, ms=4.5, zorder=5)
            ax.plot(*np.array([kingpin, ICR]).T, color=CENTRE, lw=0.7, ls="--", zorder=1)
            arrow(ax, contact, contact + 0.62 * along(delta), STEER, 1.2)
            text = rf"$\delta_{{{name}{'l' if side > 0 else 'r'}}}$"
            tip = contact + 0.78 * along(delta)
            label(ax, tip[0], tip[1], text, STEER)

    for centre, phi, name in ((front, PHI_F, "f"), (rear, PHI_R, "r")):
        wheel(ax, centre, phi, facecolor="white", edgecolor=STEER, lw=1.3, ls="--", zorder=4)
        ax.plot(*np.array([centre, ICR]).T, color=CENTRE, lw=1.4, zorder=2)
        arrow(ax, centre, centre + 1.0 * along(phi), STEER, 1.8)
        angle_arc(ax, centre, 0.62, 0.0, phi, STEER)
        tip = centre + 1.14 * along(phi)
        label(ax, tip[0], tip[1], rf"$V_{name}$", STEER)
        mid = centre + 0.78 * along(phi / 2)
        label(ax, mid[0], mid[1], rf"$\varphi_{name}$", STEER)
    for centre, name, dx in ((front, "F", 0.17), (rear, "R", -0.17)):
        ax.plot(*centre, "o", color=INK, ms=6, zorder=6)
        label(ax, centre[0] + dx, centre[1] - 0.24, name, weight="bold")

    arrow(ax, (0, 0), (0.55, 0), FRAME, 2.2)
    arrow(ax, (0, 0), (0, 0.55), FRAME, 2.2)
    ax.plot(0, 0, "s", color=FRAME, ms=6, zorder=7)
    label(ax, 0.66, -0.02, "$x$", FRAME)
    label(ax, 0.14, 0.6, "$y$", FRAME)
    label(ax, 0.08, 0.2, "base_link", FRAME, family="monospace", fontsize=9.5, ha="left")

    ax.plot(*ICR, "o", color=CENTRE, ms=7, zorder=6)
    ax.text(ICR[0] + 0.16, ICR[1] + 0.02, "turning centre\n$(-\\beta/\\kappa,\\ 1/\\kappa)$", color=CENTRE,
            va="center", ha="left")

    low = -1.45
    for x in (A_R, 0.0, A_F):
        extension(ax, (x, -0.05 if x == 0.0 else -TRACK / 2 - 0.1), (x, low - 0.45))
    dimension(ax, (A_R, low), (0.0, low), "$-a_r$")
    dimension(ax, (0.0, low), (A_F, low), "$a_f$")
    dimension(ax, (A_R, low - 0.36), (A_F, low - 0.36), "$L$ (wheelbase)")

    left = A_R - 1.15
    for side in (1.0, -1.0):
        extension(ax, (A_R - 0.33, side * TRACK / 2), (left - 0.08, side * TRACK / 2))
    dimension(ax, (left, -TRACK / 2), (left, TRACK / 2), "$B$\n(track)")

    ax.set_xlim(left - 0.4, A_F + 1.35)
    ax.set_ylim(low - 0.55, ICR[1] + 0.25)
    ax.set_title("the car, seen from above, in a left turn", fontsize=11)


def draw_hub(ax):
    """The front right wheel, enlarged: kingpin, hub offset and the direction delta."""
    delta, hub = 0.35, 0.62
    kingpin = np.array([0.0, 0.0])
    contact = kingpin - hub * across(delta)
    ax.plot([0, 0], [0, 0.75], color=BODY, lw=6, solid_capstyle="round")
    ax.plot(*np.array([kingpin, contact]).T, color=BODY, lw=6)
    u, v = along(delta) * 0.62, across(delta) * 0.17
    ax.add_patch(Polygon([contact + u + v, contact + u - v, contact - u - v, contact - u + v], closed=True,
                         facecolor="#d9dce1", edgecolor=INK, lw=1.4, zorder=1))
    ax.plot(*np.array([kingpin, contact]).T, color=BODY, lw=3, zorder=2)
    ax.plot(*kingpin, "o", color=INK, ms=9, zorder=5)
    ax.plot(*contact, "o", color="white", mec=INK, ms=8, zorder=5)
    ax.plot([contact[0], contact[0] + 1.15], [contact[1]] * 2, color=GHOST, lw=1.0, ls="--", zorder=3)
    arrow(ax, contact, contact + 1.15 * along(delta), STEER, 1.8)
    angle_arc(ax, contact, 0.85, 0.0, delta, STEER)
    label(ax, *(contact + 1.0 * along(delta / 2)), r"$\delta_{fr}$", STEER)
    tip = contact + 1.27 * along(delta)
    label(ax, tip[0] + 0.02, tip[1] + 0.03, r"$S_{fr}$", STEER)

    side = -along(delta) * 0.78
    dimension(ax, kingpin + side, contact + side, "$h$", offset=-0.14 * along(delta))
    for point in (kingpin, contact):
        extension(ax, point, point + side * 1.08)
    ax.plot(*np.array([kingpin, kingpin + 0.75 * across(delta)]).T, color=CENTRE, lw=1.0, ls="--")
    label(ax, *(kingpin + 0.93 * across(delta) + np.array([-0.22, 0.0])), "to the turning\ncentre", CENTRE, fontsize=9.5)
    label(ax, 0.16, 0.1, "kingpin", fontsize=9.5, ha="left")
    label(ax, 0.12, 0.56, "axle", fontsize=9.5, ha="left")
    ax.annotate("tyre contact\npoint", xy=contact + np.array([0.02, -0.05]), xytext=(0.62, -1.15), fontsize=9.5,
                ha="center", va="center", arrowprops=dict(arrowstyle="-", color=INK, lw=0.7))
    ax.set_xlim(-1.15, 1.6)
    ax.set_ylim(-1.45, 1.1)
    ax.set_title("front right wheel, enlarged", fontsize=11)


def main():
    figure, (car, hub) = plt.subplots(1, 2, figsize=(11.0, 6.6), gridspec_kw={"width_ratios": [2.05, 1.0]})
    draw_car(car)
    draw_hub(hub)
    for ax in (car, hub):
        ax.set_aspect("equal")
        ax.axis("off")
    figure.tight_layout()
    folder = pathlib.Path(__file__).resolve().parent
    figure.savefig(folder / "car.svg", metadata={"Date": None})
    figure.savefig(folder / "car.png", dpi=110, facecolor="white")


if __name__ == "__main__":
    main()
