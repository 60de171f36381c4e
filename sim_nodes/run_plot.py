"""Plot of a run from above: the world, the paths of everything that moved, and the present states."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Sequence
from itertools import cycle, pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator

from sim_nodes.extents import outline
from sim_nodes.geometry import Array, Pose2, Vector, lengths_along
from sim_nodes.physics import BodyState, Engine
from sim_nodes.robots.robot import Robot
from sim_nodes.robots.urdf_check import link_parts
from sim_nodes.run_data import RobotTrack
from sim_nodes.simulation import Simulation
from sim_nodes.spawning import Spawned

WIDTH = 1400  # [pixels]
DPI = 140
WALL, FLOOR, GRID, INK = "#3b4252", "#fbfaf7", "#e6e3dc", "#2b303b"
PROP = "#b8bdc9"  # of the world, but movable
SPAWNED, SPAWNED_EDGE, START = "#e8953a", "#a85f12", "#3a9d5d"
ROBOTS = ("#2f6fb7", "#b7442f", "#7a4fb5", "#2f9a9a")  # in turn, by robot
GOAL = "#c8322b"
BENCH = "#d5d9e2"
FURNITURE = "#e9dcc3"  # static spawned bodies
FLAG = np.array([(0.0, 0.0), (0.0, 0.42), (0.3, 0.31), (0.0, 0.2), (0.0, 0.0)])  # [m], planted at the origin
FULL_SIZE = 8.0  # [m] width of a world from which flags and arrows have full size
TICKS = ((0.25, 2.5), (0.5, 5.0), (1.0, 25.0), (5.0, 60.0))  # [m] spacing, and maximum width of the world
OUTLINED = (withStroke(linewidth=3.2, foreground="white"),)
NOTICEABLE = 0.05  # [m] minimum displacement
MAX_IN_TITLE, MAX_LABELS = 3, 12
LABEL_GAP = 0.06  # [m] between a body and its label


def top_down(simulation: Simulation) -> bytes:
    """Plot a simulation as PNG, `WIDTH` pixels wide."""
    left, bottom, right, top = simulation.world.extent
    inches = WIDTH / DPI
    axes_width = 0.88
    height = inches * axes_width * (top - bottom) / (right - left) + 1.55
    figure = Figure(figsize=(inches, height), dpi=DPI, facecolor="white")
    axes = figure.add_axes((0.085, 0.95 / height, axes_width, (height - 1.55) / height))
    _draw_floor(axes, simulation)
    size = min(1.0, (right - left) / FULL_SIZE)  # of symbols that are drawn larger than life
    entries: list[Line2D | Patch] = []
    for robot, colour in _coloured(simulation):
        entries += _draw_record(axes, simulation.run_data.records[robot.name], robot, colour, size)
    for prop in simulation.world.props:
        path = simulation.run_data.trails.get(prop.name, [])
        if _horizontal_length(path) > NOTICEABLE:
            entries.append(_draw_path(axes, path, WALL))
    entries += _draw_all_spawned(axes, simulation)
    for robot, colour in _coloured(simulation):
        _draw_robot(axes, robot, simulation.engine, colour)
    _draw_titles(axes, simulation)
    unique = {str(entry.get_label()): entry for entry in entries}
    if unique:
        figure.legend(
            handles=list(unique.values()),
            loc="lower center",
            ncol=min(5, len(unique)),
            frameon=False,
            fontsize=10.5,
            labelcolor=INK,
        )
    FigureCanvasAgg(figure)
    file = io.BytesIO()
    figure.savefig(file, format="png", metadata={"Software": None})
    return file.getvalue()


def _coloured(simulation: Simulation) -> Iterable[tuple[Robot, str]]:
    """Return the robots with their colours."""
    return zip(simulation.robots.values(), cycle(ROBOTS), strict=False)


def _draw_floor(axes: Axes, simulation: Simulation) -> None:
    left, bottom, right, top = simulation.world.extent
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", facecolor=FLOOR)
    width = right - left
    ticks = next((tick for tick, widest in TICKS if width <= widest), 10.0)
    axes.xaxis.set_major_locator(MultipleLocator(ticks))
    axes.yaxis.set_major_locator(MultipleLocator(ticks))
    axes.grid(color=GRID, linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, labelsize=10, length=3)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_xlabel("x [m]", fontsize=11, color=INK)
    axes.set_ylabel("y [m]", fontsize=11, color=INK)
    # Where nothing drives, walls are benches of arms.
    face = WALL if any(robot.drives for robot in simulation.robots.values()) or not simulation.robots else BENCH
    for wall in simulation.world.walls:
        corners = outline(wall.part, BodyState((0.0, 0.0, 0.0)))
        axes.add_patch(Polygon(corners, facecolor=face, edgecolor=WALL, linewidth=0.5, zorder=2))
    for prop in simulation.world.props:
        colour = WALL if prop.model.static else PROP
        for part in prop.model.parts:
            corners = outline(part, simulation.engine.body_state(prop.name))
            axes.add_patch(Polygon(corners, facecolor=colour, edgecolor=WALL, linewidth=0.8, zorder=2))


def _draw_titles(axes: Axes, simulation: Simulation) -> None:
    moved = [_moved(robot, simulation.run_data.records[robot.name]) for robot in simulation.robots.values()]
    shown = ", ".join(moved[:MAX_IN_TITLE]) + (
        f" and {len(moved) - MAX_IN_TITLE} more" if len(moved) > MAX_IN_TITLE else ""
    )
    axes.set_title(
        f"World “{simulation.world.name}”", loc="left", fontsize=15, fontweight="bold", color=INK, pad=10
    )
    axes.set_title(
        f"{shown} in {simulation.time:.1f} s" if moved else f"{simulation.time:.1f} s",
        loc="right",
        fontsize=11.5,
        color=INK,
        pad=10,
    )


def _moved(robot: Robot, record: RobotTrack) -> str:
    if robot.drives:
        return f"{robot.name} drove {_length(record.path):.1f} m"
    return f"{robot.name} moved its tool {_length(record.tool):.1f} m"


def _length(path: Sequence[Sequence[float]]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(path))


def _horizontal_length(path: Sequence[Vector]) -> float:
    """Return the length of a path as seen from above: falling does not count."""
    return _length([(x, y) for x, y, _ in path])


def _draw_record(axes: Axes, record: RobotTrack, robot: Robot, colour: str, size: float) -> list[Line2D | Patch]:
    """Draw paths, start and goals of a robot; returns the legend entries."""
    entries: list[Line2D | Patch] = []
    if len(record.tool) > 1:
        tool = np.array(record.tool)[:, :2]
        axes.plot(*tool.T, color=colour, linewidth=1.6, solid_capstyle="round", zorder=9, path_effects=OUTLINED)
        entries.append(Line2D([], [], color=colour, linewidth=1.6, label=f"tool of {robot.name}"))
    if not robot.drives:
        return entries
    if len(record.path) > 1:
        path = np.array(record.path)
        axes.plot(*path.T, color="white", linewidth=6.0, solid_capstyle="round", zorder=3)
        axes.plot(*path.T, color=colour, linewidth=2.8, solid_capstyle="round", zorder=4)
        _draw_direction(axes, path, colour, size)
        entries.append(Line2D([], [], color=colour, linewidth=2.8, label=f"path of {robot.name}"))
    start = record.start
    axes.plot(
        start.x, start.y, "o", markersize=11, color=START, markeredgecolor="white", markeredgewidth=1.5, zorder=6
    )
    entries.append(Line2D([], [], marker="o", linestyle="", markersize=9, color=START, label="start"))
    for goal in record.goals:
        flag = size * FLAG + np.array([goal.x, goal.y])
        for edge, width, order in (("white", 4.5, 9), (GOAL, 2.0, 10)):
            patch = Polygon(flag, facecolor=GOAL, edgecolor=edge, linewidth=width, joinstyle="round", zorder=order)
            axes.add_patch(patch)
    if record.goals:
        flag_marker = Path(FLAG - FLAG.mean(axis=0))
        entries.append(Line2D([], [], marker=flag_marker, linestyle="", markersize=14, color=GOAL, label="goal"))
    return entries


def _draw_direction(axes: Axes, path: Array, colour: str, size: float) -> None:
    """Draw arrowheads along a path, about every 1.2 m; `size` scales them and their spacing."""
    along = lengths_along(path)
    for mark in size * np.arange(0.8, along[-1] / size - 0.4, 1.2):
        index = int(np.searchsorted(along, mark))
        behind = max(index - 5, 0)
        direction = path[index] - path[behind]
        norm = float(np.hypot(*direction))
        if norm < 1e-6:
            continue
        ahead = direction / norm
        side = np.array([-ahead[1], ahead[0]])
        tip, base = path[index] + 0.13 * size * ahead, path[index] - 0.07 * size * ahead
        head = np.array([tip, base + 0.1 * size * side, base + 0.03 * size * ahead, base - 0.1 * size * side])
        axes.add_patch(Polygon(head, facecolor=colour, edgecolor="white", linewidth=0.8, zorder=5))


def _draw_all_spawned(axes: Axes, simulation: Simulation) -> list[Line2D | Patch]:
    """Draw spawned bodies with their paths; returns the legend entries."""
    entries: list[Line2D | Patch] = []
    occupied = _occupied_points(simulation)
    for index, (name, spawned) in enumerate(simulation.entities.spawned.items()):
        state = simulation.engine.body_state(name)
        face = FURNITURE if spawned.model.static else SPAWNED
        _draw_spawned(axes, spawned, state, face)
        label = (
            "spawned, with the robot at that time"
            if any(robot.drives for robot in simulation.robots.values())
            else "spawned"
        )
        entries.append(Patch(facecolor=face, edgecolor=SPAWNED_EDGE, label=label))
        path = simulation.run_data.trails.get(name, [])
        text = f"{name}\nspawned at\n{spawned.time:.2f} s"
        length = _horizontal_length(path)
        if length > NOTICEABLE:
            text += f",\nmoved {length:.2f} m"
            entries.append(_draw_path(axes, path, SPAWNED_EDGE))
        if index < MAX_LABELS:
            for robot in simulation.robots.values():
                if robot.drives:
                    _draw_moment(axes, simulation.run_data.records[robot.name], robot, spawned, state)
            _label(axes, text, spawned, state, occupied)
    return entries


def _draw_path(axes: Axes, path: Sequence[Vector], colour: str) -> Line2D:
    """Draw the path of a body; returns the legend entry."""
    axes.plot(
        *np.array(path)[:, :2].T, color=colour, linewidth=1.5, linestyle="--", zorder=9.5, path_effects=OUTLINED
    )
    axes.plot(*path[0][:2], "o", markersize=6, color=FLOOR, markeredgecolor=colour, zorder=9.6)
    return Line2D([], [], color=colour, linewidth=1.5, linestyle="--", label="was moved")


def _draw_spawned(axes: Axes, spawned: Spawned, state: BodyState, face: str) -> None:
    under = spawned.model.static  # such as a table, with other bodies on it
    for part in spawned.model.parts:
        axes.add_patch(
            Polygon(
                outline(part, state),
                facecolor=face,
                edgecolor=SPAWNED_EDGE,
                linewidth=0.8 if under else 1.4,
                zorder=2.5 if under else 8.5,
            )
        )


def _draw_moment(axes: Axes, record: RobotTrack, robot: Robot, spawned: Spawned, state: BodyState) -> None:
    """Draw a ring at a robot's position when a body was spawned, connected to the body."""
    times = np.array(record.times)
    index = int(np.searchsorted(times, spawned.time, side="right")) - 1
    if index < 1:
        return
    x, y = record.path[index]
    style = {"edgecolor": SPAWNED_EDGE, "linewidth": 1.3, "linestyle": (0, (3, 2))}
    axes.add_patch(Circle((x, y), robot.mobile.declaration.radius, facecolor="none", zorder=5, **style))
    axes.plot(
        [x, state.position[0]], [y, state.position[1]], color=SPAWNED_EDGE, linewidth=1.0, linestyle=":", zorder=3
    )


def _occupied_points(simulation: Simulation) -> Array:
    """Return points that labels should not cover, shape (n, 2): of walls, paths and goals."""
    points = [np.array(record.path).reshape(-1, 2) for record in simulation.run_data.records.values()]
    points += [
        np.array([(goal.x, goal.y)]) for record in simulation.run_data.records.values() for goal in record.goals
    ]
    for wall in simulation.world.walls:
        along = np.arange(-wall.length / 2, wall.length / 2, 0.05)
        points.append(np.column_stack([wall.x + along * math.cos(wall.yaw), wall.y + along * math.sin(wall.yaw)]))
    return np.concatenate(points) if points else np.zeros((0, 2))


def _label(axes: Axes, text: str, spawned: Spawned, state: BodyState, occupied: Array) -> None:
    """Label a body on the side where the text covers the fewest points."""
    x, y, _ = state.position
    extents = (float(np.abs(outline(part, state) - (x, y)).max()) for part in spawned.model.parts)
    reach = max(extents, default=0.0) + LABEL_GAP
    label = axes.text(
        x,
        y,
        text,
        fontsize=9.5,
        color=SPAWNED_EDGE,
        linespacing=1.15,
        zorder=10,
        path_effects=[withStroke(linewidth=3, foreground=FLOOR)],
    )
    box = label.get_window_extent().transformed(axes.transData.inverted())
    sides = (
        ("left", "center", x + reach, y),
        ("right", "center", x - reach, y),
        ("center", "top", x, y - reach),
        ("center", "bottom", x, y + reach),
    )

    def covered(side: tuple[str, str, float, float]) -> int:
        horizontal, vertical, left, bottom = side
        left -= box.width * {"left": 0.0, "center": 0.5, "right": 1.0}[horizontal]
        bottom -= box.height * {"bottom": 0.0, "center": 0.5, "top": 1.0}[vertical]
        inside = (occupied >= (left, bottom)) & (occupied <= (left + box.width, bottom + box.height))
        return int(inside.all(axis=1).sum())

    horizontal, vertical, left, bottom = min(sides, key=covered)
    label.set(ha=horizontal, va=vertical, position=(left, bottom))


def _draw_robot(axes: Axes, robot: Robot, engine: Engine, colour: str) -> None:
    """Draw a robot to scale: a wheeled one with a wedge for its heading, others link by link."""
    if not robot.drives:
        for link, parts in link_parts(robot.declaration).items():
            place = BodyState(*engine.link_pose(robot.name, link))
            for part in parts:
                shape = outline(part, place)
                axes.add_patch(Polygon(shape, facecolor=(*to_rgb(colour), 0.35), edgecolor=colour, zorder=8))
        return
    pose, radius = engine.body_state(robot.name).planar, robot.mobile.declaration.radius
    axes.add_patch(Circle((pose.x, pose.y), radius, facecolor=colour, edgecolor="white", linewidth=1.2, zorder=8))
    nose = [pose.compose(Pose2(x * radius, y * radius, 0.0)) for x, y in ((0.8, 0.0), (-0.45, 0.5), (-0.45, -0.5))]
    axes.add_patch(Polygon([(p.x, p.y) for p in nose], facecolor="white", linewidth=0, zorder=8))
