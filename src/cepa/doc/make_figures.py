"""Draws the pictures of the pages with the library itself, beside this file."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "src"), str(HERE.parent / "test")]

import plain_cepa as reference  # noqa: E402
from planar_flight import BODY_RADIUS_M, SCAN_EVERY, STEP_S, Scene, Uav, fly, to_goal  # noqa: E402

from cepa import SLOW_DETOURS, CepaParameters, Dynamic, Improved, LaserScan2D, LidarAttitude, levelled, view  # noqa: E402
from cepa.levelling import needed_sight  # noqa: E402
from cepa.scan import Grid  # noqa: E402
from cepa.thesis.emergency import open_sections  # noqa: E402
from cepa.thesis.kernels.emergency import safe_directions  # noqa: E402

PARAMETERS = CepaParameters(speed_fractions=SLOW_DETOURS)
INNER, OUTER, SCAN, REFERENCE, OUTPUT = "#e8711a", "#2b8cbe", "#404040", "#3b6fd4", "#c99700"
RED, GREEN = "#cc1f1a", "#2a9d3a"


def main() -> None:
    """Write every figure."""
    plt.rcParams.update({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False})
    for name, draw in (
        ("cushions", draw_cushions),
        ("steering", draw_steering),
        ("emergency", draw_emergency),
        ("extensions", draw_extensions),
        ("side_flip", draw_side_flip),
    ):
        figure = draw()
        figure.savefig(HERE / f"{name}.png", dpi=110, bbox_inches="tight")
        plt.close(figure)


def look(scene: Scene, beams: int = 1440) -> LaserScan2D:
    """Return what a lidar at the origin sees."""
    angles = -math.pi + np.arange(beams) * 2.0 * math.pi / beams
    ranges = scene.ranges(np.zeros(2), np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return LaserScan2D(np.where(ranges > 10.0, np.inf, ranges), -math.pi, 2.0 * math.pi / beams, 0.06, 10.0)


def draw_cushions():
    """Both algorithms' cushions at 1 m/s: straight sides, a round end or an arc about the UAV."""
    figure, axes = plt.subplots(1, 2, figsize=(8.0, 3.0), sharey=True)
    for ax, name, equation in zip(axes, ("original", "improved"), ("6.2", "6.7")):
        for radius, colour, label in ((1.2, OUTER, "$SC_{UB}$"), (0.5, INNER, "$SC_{LB}$")):
            outline = view.cushion_outline(name, (1.0, 0.0), radius, PARAMETERS.time_horizon)
            ax.fill(*outline.T, color=colour, alpha=0.18)
            ax.plot(*outline.T, color=colour, label=label)
            ax.plot(*view.circle(radius).T, color=colour, lw=0.7, ls=":")
        _arrow(ax, (1.0, 0.0), OUTPUT, "v")
        ax.set(title=f"{name} (equation {equation})", xlabel="x [m]", aspect="equal")
    figure.suptitle(f"|v| = 1 m/s, T = {PARAMETERS.time_horizon:g} s", fontsize=8)
    axes[0].set_ylabel("y [m]")
    axes[1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    return figure


def draw_steering():
    """One decision between columns, and the cost of every candidate."""
    columns = np.array(
        [(2.6, 0.25, 0.25), (1.9, -1.7, 0.2), (3.4, 2.0, 0.3), (0.4, 1.9, 0.2), (-2.2, -1.0, 0.3)]
    )
    scan, v_ref, v_uav = look(Scene(columns)), (2.0, 0.0), (1.8, 0.0)
    decision = Improved(PARAMETERS).steer(scan, v_ref, v_uav)
    figure, (plane, costs) = plt.subplots(1, 2, figsize=(9.5, 4.0), width_ratios=(1.0, 1.15))
    _draw_scene(plane, columns, scan)
    for radius, colour in ((PARAMETERS.r_ub, OUTER), (PARAMETERS.r_lb, INNER)):
        outline = view.cushion_outline("improved", decision.velocity_xy, radius, PARAMETERS.time_horizon)
        plane.fill(*outline.T, color=colour, alpha=0.18)
        plane.plot(*outline.T, color=colour)
    beams = scan.full_turn(PARAMETERS.dropout_beams)
    rejected = view.rejected_directions(beams, PARAMETERS, math.hypot(*v_ref))
    for share, colour, label in (
        (1.0, RED, "every speed rejected"),
        (0.0, "#e6b400", "some speeds rejected"),
    ):
        chosen = (rejected == 1.0) if share == 1.0 else (rejected > 0.0) & (rejected < 1.0)
        if not chosen.any():
            continue
        ring = np.stack([np.cos(beams.angles), np.sin(beams.angles)])[:, chosen] * (PARAMETERS.r_ub + 0.12)
        plane.plot(*ring, ".", color=colour, ms=3, label=label)
    _arrow(plane, v_ref, REFERENCE, "$v_{ref}$")
    _arrow(plane, decision.velocity_xy, OUTPUT, "$v_{out}$")
    plane.set(xlim=(-2.8, 4.6), ylim=(-2.6, 3.6), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    plane.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncol=3, frameon=False, fontsize=7)
    _draw_costs(costs, scan, v_ref, v_uav, decision)
    return figure


def _draw_costs(ax, scan, v_ref, v_uav, decision) -> None:
    velocities, values = reference.improved_costs(PARAMETERS, scan, v_ref, v_uav)
    speed = np.hypot(*velocities.T)
    for fraction, shade in zip(PARAMETERS.speed_fractions, (0.0, 0.25, 0.45, 0.62)):
        of_speed = np.isclose(speed, fraction * math.hypot(*v_ref))
        bearing = np.degrees(np.arctan2(velocities[of_speed, 1], velocities[of_speed, 0]))
        order = np.argsort(bearing)
        cost = np.where(np.isinf(values[of_speed]), np.nan, values[of_speed])
        ax.plot(bearing[order], cost[order], color=str(shade), lw=1.0, label=f"{fraction:g} of |v_ref|")
    turned = math.degrees(math.atan2(decision.velocity_xy[1], decision.velocity_xy[0]))
    ax.plot(
        turned,
        decision.cost,
        "o",
        color=OUTPUT,
        label=f"answer, after {decision.directions_tested} candidates",
    )
    ax.set(xlabel="direction [deg]", ylabel="cost (6.5); gaps: rejected", xlim=(-180, 180), ylim=(-40, 120))
    ax.set_xticks(range(-180, 181, 60))
    ax.legend(frameon=False, fontsize=7)


def draw_emergency():
    """A wall and three columns (figure 8.7); then what the K filter does to a near post opposite a wall."""
    columns = np.array([(0.65 * math.cos(a), 0.65 * math.sin(a), 0.1) for a in np.radians([-125, -90, -55])])
    wall_left, wall_right = np.array([(-2.0, 0.4, 2.0, 0.4)]), np.array([(-2.0, -0.42, 2.0, -0.42)])
    post = np.array([(0.0, 0.22, 0.02)])
    figure, axes = plt.subplots(1, 3, figsize=(9.5, 3.0), sharey=True)
    cases = (
        (columns, wall_left, 50.0, True),
        (post, wall_right, 50.0, False),
        (post, wall_right, 0.3, False),
    )
    for ax, (circles, walls, slope, sections) in zip(axes, cases):
        parameters = CepaParameters(k_filter=slope)
        scan = look(Scene(circles, walls))
        decision = Improved(parameters).steer(scan, (1.0, 0.0))
        beams = scan.full_turn(parameters.dropout_beams)
        _draw_scene(ax, circles, scan)
        ax.plot(walls[0, ::2], walls[0, 1::2], color="#8c6d4f", lw=3)
        ax.plot(*view.circle(parameters.r_lb).T, color="0.5", lw=0.8)
        for ends in view.intrusions(beams, parameters)[::4]:
            ax.plot(*ends.T, color=RED, lw=0.5, alpha=0.6)
        arrows = [(decision.emergency_original_xy, RED, "original")]
        if sections:
            _draw_sections(ax, beams, parameters)
            arrows.append((decision.emergency_improved_xy, GREEN, "improved"))
        for velocity, colour, label in arrows:
            _arrow(ax, np.array(velocity) * 0.8 / math.hypot(*velocity), colour, label, named=False)
        ax.set(
            title=f"K = {slope:g} m/rad", xlim=(-1.4, 1.4), ylim=(-1.2, 0.95), aspect="equal", xlabel="x [m]"
        )
    axes[0].set_ylabel("y [m]")
    figure.legend(
        *axes[0].get_legend_handles_labels(),
        loc="lower center",
        ncol=2,
        frameon=False,
        bbox_to_anchor=(0.5, -0.08),
    )
    return figure


def draw_extensions():
    """What is an emergency at some own speeds, and what levelling makes of a leaning lidar's beams."""
    figure, (zone, side) = plt.subplots(1, 2, figsize=(9.5, 2.9), width_ratios=(1.0, 1.35))
    aware = CepaParameters(velocity_aware_emergency=True)
    for speed, shade in ((3.0, 0.75), (2.0, 0.55), (1.0, 0.3), (0.0, 0.0)):
        outline = view.emergency_outline(aware, (speed, 0.0))
        zone.plot(*outline.T, color=str(shade), label=f"{speed:g} m/s")
    zone.add_patch(plt.Circle((0.0, 0.0), aware.body_radius, color="#8c6d4f", alpha=0.4))
    zone.set(title="edge of an emergency, by the speed ahead", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    zone.legend(frameon=False, fontsize=7, loc="upper center", ncol=4)
    zone.set(xlim=(-0.7, 2.7), ylim=(-0.7, 1.0))
    _draw_leaning(side)
    return figure


def _draw_leaning(ax) -> None:
    """Draw where the beam ahead ends, and what it then is, for a UAV 1.2 m over the floor that leans."""
    height, speed, parameters = 1.2, 2.0, CepaParameters(levelling=True)
    crate = 2.0, 0.5  # its face, its height
    for lean, colour in ((15.0, GREEN), (22.0, RED), (50.0, OUTPUT)):
        pitch = math.radians(lean)
        hits_crate = height - crate[0] * math.tan(pitch) < crate[1] and lean < 30.0
        reading = crate[0] / math.cos(pitch) if hits_crate else height / math.sin(pitch)
        attitude = LidarAttitude.of_mounted(height, (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)))
        result = levelled(LaserScan2D([reading], 0.0, 0.1, 0.06, 10.0), attitude, parameters, speed)
        verdict = "obstacle" if np.isfinite(result.ranges[0]) else "free" if result.seen[0] else "unseen"
        end = reading * math.cos(pitch), height - reading * math.sin(pitch)
        ax.plot((0.0, end[0]), (height, end[1]), color=colour, label=f"{lean:.0f} degrees: {verdict}")
        ax.plot(*end, "o", color=colour, ms=4)
    ax.add_patch(plt.Rectangle((crate[0], 0.0), 0.6, crate[1], color="#8c6d4f"))
    ax.axhline(0.0, color="0.4")
    ax.axhline(parameters.floor_margin, color="0.6", lw=0.8, ls=":", label="floor_margin")
    sight = needed_sight(parameters, speed)
    ax.axvline(sight, color=REFERENCE, lw=0.8, ls="--", label="sight needed at 2 m/s")
    ax.plot(0.0, height, "s", color=SCAN)
    ax.set(title="what the beam ahead is when the UAV leans", xlabel="ahead [m]", ylabel="height [m]")
    ax.set(xlim=(-0.2, 6.2), ylim=(-0.1, 1.6))
    ax.legend(frameon=False, fontsize=7, loc="upper right")


def _draw_sections(ax, beams, parameters) -> None:
    grid = Grid(beams.ranges.size, beams.increment)
    corridor = parameters.body_radius, parameters.emergency_lookahead
    safe = safe_directions(beams.ranges, beams.seen, grid.cos, grid.sin, *corridor)
    for section in open_sections(safe):
        angle = beams.angle_0 + (section.first + np.arange(section.beams)) * beams.increment
        edge = np.stack([np.cos(angle), np.sin(angle)]) * parameters.emergency_lookahead
        ax.fill(*np.column_stack([np.zeros(2), edge]), color=GREEN, alpha=0.15)


def _draw_scene(ax, columns, scan) -> None:
    for x, y, radius in columns:
        ax.add_patch(plt.Circle((x, y), radius, color="#8c6d4f"))
    angles = scan.angle_min + np.arange(scan.ranges.size) * scan.angle_increment
    seen = np.isfinite(scan.ranges)
    ax.plot(
        scan.ranges[seen] * np.cos(angles[seen]),
        scan.ranges[seen] * np.sin(angles[seen]),
        ".",
        ms=1.2,
        color=SCAN,
    )


def _arrow(ax, velocity, colour, label, named: bool = True) -> None:
    offset = (0, -12) if colour == REFERENCE else (4, 4)
    ax.annotate("", velocity, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2.0})
    ax.plot([], [], color=colour, lw=2.0, label=label)
    if named:
        ax.annotate(label, velocity, offset, textcoords="offset points", color=colour, fontsize=8)


FLIP_SEED, FLIP_SPEED_M_S, FLIP_GOAL = 8, 4.0, (26.0, 0.0)
FLIP_WINDOW_M, BEFORE_S, COMMANDS_EVERY = (-0.5, 17.0, -8.0, 6.5), 1.6, 6
"""Of the map; what the right panel shows before the contact; every so many scans an arrow."""


def thick_forest(seed: int) -> Scene:
    """Return 0.12 trunks per m2 of 0.25 to 1 m radius, some overlapping, none near the start."""
    rng = np.random.default_rng(seed)
    low, high = (3.0, -7.0, 0.25), (24.0, 7.0, 1.0)
    trunks = np.column_stack([rng.uniform(a, b, 40) for a, b in zip(low, high)])
    return Scene(circles=trunks[np.hypot(trunks[:, 0], trunks[:, 1]) - trunks[:, 2] > 2.0])


def draw_side_flip():
    """One forest, flown by both algorithms at 4 m/s: the command of one changes its side too late."""
    scene, flights = thick_forest(FLIP_SEED), {}
    for name, algorithm in (("improved", Improved(PARAMETERS)), ("dynamic", Dynamic(PARAMETERS))):
        pilot, rng = to_goal(FLIP_GOAL, FLIP_SPEED_M_S), np.random.default_rng(FLIP_SEED)
        flights[name] = fly(algorithm, scene, pilot, Uav(), rng, time_limit_s=20.0)
    path = np.array(flights["improved"].path)
    clearance_m = np.array([scene.clearance(position) for position in path])
    contact = int(np.argmax(clearance_m < BODY_RADIUS_M))
    assert contact > 0
    assert not flights["dynamic"].contact
    figure, (plan, directions) = plt.subplots(1, 2, figsize=(9.5, 4.0), width_ratios=(1.6, 1.0))
    _draw_flight(plan, flights["dynamic"], GREEN, "dynamic", len(flights["dynamic"].path))
    _draw_flight(plan, flights["improved"], RED, "improved", contact + 1)
    _draw_forest(plan, scene, path[contact])
    _draw_directions(directions, flights["improved"], contact)
    figure.tight_layout()
    return figure


def _draw_flight(ax, flight, colour: str, name: str, scans: int) -> None:
    """Draw the way, the UAV's own circle and the commands of the first scans."""
    path, commands = np.array(flight.path)[:scans], np.array(flight.commands)[:scans]
    ax.plot(*path.T, color=colour, lw=1.5, zorder=3, label=f"{name}, and its commands")
    shown = np.arange(scans - 1, -1, -COMMANDS_EVERY)
    arrows = {"angles": "xy", "scale_units": "xy", "scale": 3.0, "width": 0.004, "zorder": 4}
    ax.quiver(*path[shown].T, *commands[shown].T, color=colour, alpha=0.6, **arrows)
    for index in shown[::2]:
        ax.add_patch(plt.Circle(path[index], BODY_RADIUS_M, fill=False, color=colour, lw=0.5, zorder=3))


def _draw_forest(ax, scene: Scene, contact_xy: np.ndarray) -> None:
    for x, y, radius in scene.circles:
        ax.add_patch(plt.Circle((x, y), radius, color="#b9a58c", zorder=1))
    ax.add_patch(plt.Circle(contact_xy, BODY_RADIUS_M, color=RED, zorder=5))
    line = {"arrowstyle": "-", "color": RED}
    kind = {"textcoords": "offset points", "color": RED, "fontweight": "bold", "arrowprops": line}
    ax.annotate("contact", contact_xy, (24, 40), **kind)
    left, right, low, high = FLIP_WINDOW_M
    ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    ax.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=2)


def _draw_directions(ax, flight, contact: int) -> None:
    """Draw the directions of command and velocity over the time before the contact."""
    period_s = SCAN_EVERY * STEP_S
    first = contact - round(BEFORE_S / period_s)
    velocity = np.gradient(np.array(flight.path), period_s, axis=0)
    times_s = (np.arange(first, contact + 1) - contact) * period_s
    for values, colour, label in (
        (np.array(flight.commands), RED, "command"),
        (velocity, SCAN, "velocity"),
    ):
        x, y = values[first : contact + 1].T
        ax.plot(times_s, np.degrees(np.unwrap(np.arctan2(y, x))), color=colour, label=label)
    ax.axvline(0.0, color=RED, lw=1.0, ls=":")
    ax.set(xlabel="time before the contact [s]", ylabel="direction [deg]")
    ax.set_title("improved: the velocity cannot follow", loc="left", fontsize=8)
    ax.legend(frameon=False)


if __name__ == "__main__":
    main()
