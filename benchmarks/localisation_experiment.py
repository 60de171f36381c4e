"""Evaluation of a campaign with `scenarios/experiments/localisation.osc`: error against noise and lost beams.

    python benchmarks/localisation_experiment.py FOLDER [--simulator NAME]

FOLDER is that of the campaign, and gets `localisation.png` (a heat map and two curves), `localisation.csv` (the
cells of the heat map) and `localisation.txt`, which is also printed. `make experiment-localisation` does both.

The error of a run is the distance between where the robot believes to be and where it is, mean over the run.
Confidence intervals are of the mean over seeds, at 95 %, by Student's t, because seeds are independent.
Correlations are Spearman's, over all runs. The effect of lost beams is small compared with that of noise, which
hides it from a correlation over all runs. So runs are compared in pairs with the same seed and noise. The result
is the mean of the ratios of their errors, with its interval by Student's t of the logarithms, and Wilcoxon's
test. All runs count, also failed ones.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.stats import spearmanr, t, wilcoxon

NOISE, DROP = "noise.parameter_value", "drop.parameter_value"
ERROR, REACHED = "turtlebot4.localisation_error", "turtlebot4.goals_reached"
LEVEL = 0.95
INK, LINE, BAND, PALE = "#2b303b", "#2f6fb7", "#9fc1e6", "#b8bec9"


@dataclass(frozen=True)
class Runs:
    """Runs of a campaign by index."""

    noise: np.ndarray  # standard deviation of ranges [m]
    drop: np.ndarray  # share of beams that are lost
    seed: np.ndarray
    error: np.ndarray  # [m]
    reached: np.ndarray  # whether the robot reached its goal


@dataclass(frozen=True)
class Estimate:
    """A mean over seeds with its confidence interval; that of one seed has none."""

    mean: float
    low: float
    high: float


def read(table: Path) -> Runs:
    """The runs of a table of results.

    Raises:
        ValueError: A run has no error, or the table is empty.
    """
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise ValueError(f"{table} has no runs")
    for row in rows:
        missing = [name for name in (NOISE, DROP, ERROR, REACHED) if not row.get(name)]
        if missing:
            where = f"run {row.get('run')} of {table}"
            raise ValueError(
                f"{where} has no value of {', '.join(missing)}: {row.get('reason') or 'no reason is given'}"
            )
    noise, drop, seed, error = (
        np.array([float(row[name]) for row in rows]) for name in (NOISE, DROP, "seed", ERROR)
    )
    return Runs(noise, drop, seed, error, reached=np.array([float(row[REACHED]) > 0.0 for row in rows]))


def over_seeds(runs: Runs, chosen: np.ndarray) -> Estimate:
    """The mean error of chosen runs: of each seed, then over seeds."""
    seeds = np.unique(runs.seed[chosen])
    means = np.array([runs.error[chosen & (runs.seed == seed)].mean() for seed in seeds])
    mean = float(means.mean())
    if len(means) < 2:
        return Estimate(mean, float("nan"), float("nan"))
    half = float(t.ppf((1.0 + LEVEL) / 2.0, len(means) - 1) * means.std(ddof=1) / np.sqrt(len(means)))
    return Estimate(mean, mean - half, mean + half)


def paired(runs: Runs, drop: float) -> tuple[Estimate, float, int]:
    """Return the factor by which a share of lost beams changes the error.

    Args:
        runs: All runs.
        drop: The share of lost beams, which is compared with the least that there is.

    Returns:
        The geometric mean of the ratios of runs with the same seed and noise, Wilcoxon's p, and how many pairs.
    """
    errors = {(seed, noise, lost): error for seed, noise, lost, error in _by_run(runs)}
    least = float(runs.drop.min())
    ratios = np.array(
        [
            np.log(error / errors[seed, noise, least])
            for (seed, noise, lost), error in errors.items()
            if lost == drop and (seed, noise, least) in errors
        ]
    )
    mean = float(ratios.mean())
    spread = float(ratios.std(ddof=1)) if len(ratios) > 1 else float("nan")
    half = float(t.ppf((1.0 + LEVEL) / 2.0, len(ratios) - 1)) * spread / np.sqrt(len(ratios))
    interval = Estimate(*(float(np.exp(value)) for value in (mean, mean - half, mean + half)))
    return interval, float(wilcoxon(ratios).pvalue) if ratios.any() else 1.0, len(ratios)


def _by_run(runs: Runs) -> list[list[float]]:
    """Seed, noise, lost beams and error of each run."""
    table: list[list[float]] = np.column_stack([runs.seed, runs.noise, runs.drop, runs.error]).tolist()
    return table


def summary(runs: Runs, simulator: str) -> str:
    """Describe the results."""
    seeds, reached = len(np.unique(runs.seed)), int(runs.reached.sum())
    text = io.StringIO()
    print(f"{len(runs.error)} runs in {simulator}, {seeds} for each pair of noise and lost beams", file=text)
    print(f"goal reached in {reached} of {len(runs.error)}", file=text)
    for name, values in (("noise", runs.noise), ("lost beams", runs.drop)):
        found = spearmanr(values, runs.error)
        print(
            f"Spearman correlation of error and {name}: {found.statistic:+.3f} (p = {found.pvalue:.1e})", file=text
        )
    for drop in np.unique(runs.drop)[1:]:
        ratio, p, pairs = paired(runs, float(drop))
        print(
            f"error with {drop:.0%} lost beams by that without, in pairs of one seed and noise: {ratio.mean:.2f} "
            f"({ratio.low:.2f} to {ratio.high:.2f}, Wilcoxon p = {p:.1e}, {pairs} pairs)",
            file=text,
        )
    for name, values, unit in (("noise", runs.noise, "m"), ("lost", runs.drop, "")):
        print(f"\n{name:>6}  error, mean over all others and {LEVEL:.0%} confidence interval", file=text)
        for value in np.unique(values):
            found = over_seeds(runs, values == value)
            interval = f"{found.low:.3f} to {found.high:.3f} m" if np.isfinite(found.low) else "one seed"
            print(f"{value:4.1f} {unit:1}  {found.mean:.3f} m  {interval}", file=text)
    return text.getvalue()


def write_cells(runs: Runs, path: Path) -> None:
    """Write the cells of the heat map."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["noise", "drop", "runs", "error", "error_low", "error_high", "reached"])
        for noise in np.unique(runs.noise):
            for drop in np.unique(runs.drop):
                cell = (runs.noise == noise) & (runs.drop == drop)
                found = over_seeds(runs, cell)
                values = [f"{value:.4f}" for value in (found.mean, found.low, found.high)]
                writer.writerow([noise, drop, int(cell.sum()), *values, float(runs.reached[cell].mean())])


def draw(runs: Runs, simulator: str, path: Path) -> None:
    """Draw the heat map and the curves."""
    figure = Figure(figsize=(13.0, 4.6), dpi=90, facecolor="white")
    heat, by_noise, by_drop = figure.subplots(1, 3, width_ratios=(1.25, 1.0, 1.0))
    _draw_heat(figure, heat, runs)
    top = 1.3 * max(
        _draw_curve(by_noise, runs, runs.noise, runs.drop), _draw_curve(by_drop, runs, runs.drop, runs.noise)
    )
    by_noise.set(xlabel="noise of ranges, standard deviation [m]", ylim=(0.0, top))
    by_noise.set_title("by noise; grey: each share of lost beams", fontsize=11, color=INK)
    by_drop.set(xlabel="share of beams that are lost", ylim=(0.0, top))
    by_drop.set_title("by lost beams; grey: each noise", fontsize=11, color=INK)
    by_noise.set_ylabel("error of the localisation [m]", color=INK)
    seeds = len(np.unique(runs.seed))
    size = f"{len(runs.error)} runs in {simulator}, {seeds} {'seed' if seeds == 1 else 'seeds'}"
    title = f"Error of the localisation with a faulty lidar: {size}"
    figure.suptitle(title, fontsize=13, fontweight="bold", color=INK)
    figure.tight_layout()
    FigureCanvasAgg(figure)
    figure.savefig(path, metadata={"Software": None})


def _draw_heat(figure: Figure, axes: Axes, runs: Runs) -> None:
    noises, drops = np.unique(runs.noise), np.unique(runs.drop)
    cells = np.array(
        [[runs.error[(runs.noise == noise) & (runs.drop == drop)].mean() for drop in drops] for noise in noises]
    )
    image = axes.imshow(cells, origin="lower", cmap="viridis", vmin=0.0, aspect="auto")
    for row, column in np.ndindex(*cells.shape):
        value = cells[row, column]
        colour = "white" if value < 0.6 * cells.max() else "black"
        axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=8.5, color=colour)
    axes.set_xticks(range(len(drops)), [f"{drop:.1f}" for drop in drops])
    axes.set_yticks(range(len(noises)), [f"{noise:.1f}" for noise in noises])
    axes.set_xlabel("share of beams that are lost")
    axes.set_ylabel("noise of ranges, standard deviation [m]")
    axes.set_title("mean over seeds", fontsize=11, color=INK)
    figure.colorbar(image, ax=axes, label="error of the localisation [m]", pad=0.02)


def _draw_curve(axes: Axes, runs: Runs, along: np.ndarray, other: np.ndarray) -> float:
    """The error along one parameter, over the other and for each of its values; returns the highest point."""
    values = np.unique(along)
    highest = 0.0
    for fixed in np.unique(other):
        single = [over_seeds(runs, (along == value) & (other == fixed)).mean for value in values]
        axes.plot(values, single, color=PALE, linewidth=0.9, zorder=1)
        highest = max(highest, *single)
    means = [over_seeds(runs, along == value) for value in values]
    axes.fill_between(
        values,
        [each.low for each in means],
        [each.high for each in means],
        color=BAND,
        alpha=0.6,
        linewidth=0,
        zorder=2,
        label=f"{LEVEL:.0%} confidence interval",
    )
    axes.plot(values, [each.mean for each in means], "o-", color=LINE, linewidth=2.2, zorder=3, label="mean")
    axes.grid(color="#e6e3dc", linewidth=0.7)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(frameon=False, fontsize=9, loc="upper left")
    return max(highest, *(each.high for each in means if np.isfinite(each.high)), 0.0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Analyse a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument("folder", type=Path, help="the folder of the campaign")
    parser.add_argument("--simulator", default="MuJoCo", metavar="NAME", help="for titles (default: %(default)s)")
    options = parser.parse_args(arguments)
    try:
        runs = read(options.folder / "runs.csv")
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    text = summary(runs, options.simulator)
    print(text, end="")
    (options.folder / "localisation.txt").write_text(text, encoding="utf-8")
    write_cells(runs, options.folder / "localisation.csv")
    draw(runs, options.simulator, options.folder / "localisation.png")
    for kind in ("png", "csv", "txt"):
        print(f"  {options.folder / 'localisation'}.{kind}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
