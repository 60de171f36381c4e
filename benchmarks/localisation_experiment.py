"""Evaluation of campaigns with `scenarios/experiments/localisation.osc`: error against noise and lost beams.

    python benchmarks/localisation_experiment.py FOLDER... [--simulator NAME]

The folders are those of campaigns with the same values and other seeds. The first one gets `localisation.png` (a
heat map and two curves), `localisation.csv` (the cells of the heat map) and `localisation.txt`, which is also
printed. `make experiment-localisation` does all.

The error of a run is the distance between where the robot believes to be and where it is, mean over the run.
Intervals have a confidence of 95 %. Those of means are over seeds, by Student's t, because seeds are independent.
Runs of one seed are not: they share the world and its random streams. Correlations are Spearman's, over all runs.

The effect of lost beams is small compared with that of noise, which hides it from a correlation over all runs. So
runs are compared in pairs with the same seed and noise. The ratios of their errors are averaged over the noises of
a seed, geometrically. The result is the mean over seeds, with its interval by Student's t of the logarithms, and
the sign test: of how many seeds the error grows. Its p-values are adjusted for the number of tests by Holm's
method. All runs count, also failed ones.

A conclusion is tested again in 20 resamples of the seeds, drawn with replacement.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.stats import spearmanr, t

from seoro.campaign.results.table import TABLE
from seoro.campaign.statistics.comparison import adjust, mcnemar
from seoro.campaign.statistics.rates import fixed_bounds

NOISE, DROP = "noise.parameter_value", "drop.parameter_value"
ERROR, REACHED = "turtlebot4.localisation_error", "turtlebot4.goals_reached"
LEVEL = 0.95
RESAMPLES = 20
INK, LINE, PALE = "#2b303b", "#2f6fb7", "#b8bec9"


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


@dataclass(frozen=True)
class Effect:
    """Factor by which a share of lost beams changes the error, over seeds."""

    ratio: Estimate  # geometric mean
    growing: int  # seeds whose error grows
    falling: int  # seeds whose error falls
    p: float  # of the sign test


def read(*tables: Path) -> Runs:
    """The runs of tables of results.

    Raises:
        ValueError: A run has no error, or the tables are empty.
    """
    rows: list[dict[str, str]] = []
    for table in tables:
        with table.open(newline="", encoding="utf-8") as file:
            read = list(csv.DictReader(file))
        if not read:
            raise ValueError(f"{table} has no runs")
        for row in read:
            missing = [name for name in (NOISE, DROP, ERROR, REACHED) if not row.get(name)]
            if missing:
                where = f"run {row.get('run')} of {table}"
                raise ValueError(
                    f"{where} has no value of {', '.join(missing)}: {row.get('reason') or 'no reason is given'}"
                )
        rows += read
    noise, drop, seed, error = (
        np.array([float(row[name]) for row in rows]) for name in (NOISE, DROP, "seed", ERROR)
    )
    return Runs(noise, drop, seed, error, reached=np.array([float(row[REACHED]) > 0.0 for row in rows]))


def over_seeds(runs: Runs, chosen: np.ndarray) -> Estimate:
    """The mean error of chosen runs: of each seed, then over seeds."""
    seeds = np.unique(runs.seed[chosen])
    return _mean(np.array([runs.error[chosen & (runs.seed == seed)].mean() for seed in seeds]))


def _mean(values: np.ndarray) -> Estimate:
    """The mean of independent values with its interval."""
    mean = float(values.mean())
    if len(values) < 2:
        return Estimate(mean, float("nan"), float("nan"))
    half = float(t.ppf((1.0 + LEVEL) / 2.0, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values)))
    return Estimate(mean, mean - half, mean + half)


def log_ratios(runs: Runs, drop: float, noise: float | None = None) -> np.ndarray:
    """Logarithm of the error with a share of lost beams by that with the least share, for each seed.

    It is the mean over pairs with the same seed and noise; with one noise, that of this pair.
    """
    errors = {(seed, noise, lost): error for seed, noise, lost, error in _by_run(runs)}
    least = float(runs.drop.min())
    by_seed: dict[float, list[float]] = {}
    for (seed, level, lost), error in errors.items():
        if lost == drop and (seed, level, least) in errors and noise in (None, level):
            by_seed.setdefault(seed, []).append(float(np.log(error / errors[seed, level, least])))
    return np.array([np.mean(ratios) for ratios in by_seed.values()])


def effect(ratios: np.ndarray) -> Effect:
    """The effect of lost beams from the logarithms of the ratios of each seed."""
    found = _mean(ratios)
    growing, falling = int((ratios > 0.0).sum()), int((ratios < 0.0).sum())
    interval = Estimate(*(float(np.exp(value)) for value in (found.mean, found.low, found.high)))
    return Effect(interval, growing, falling, mcnemar(growing, falling))


def survivals(values: np.ndarray) -> int:
    """Return in how many resamples of the seeds the interval of a mean excludes 0, with the sign of all seeds.

    Args:
        values: Value of each seed.
    """
    random = np.random.default_rng(0)
    sign = np.sign(values.mean())
    drawn = (values[random.integers(0, len(values), len(values))] for _ in range(RESAMPLES))
    return sum(_mean(sign * each).low > 0.0 for each in drawn)


def noise_effect(runs: Runs) -> np.ndarray:
    """The error with the highest noise less that with the least, for each seed."""
    noises = runs.noise.max(), runs.noise.min()
    most, least = (np.array([_of(runs, seed, noise) for seed in np.unique(runs.seed)]) for noise in noises)
    difference: np.ndarray = most - least
    return difference


def _of(runs: Runs, seed: float, noise: float) -> float:
    return float(runs.error[(runs.seed == seed) & (runs.noise == noise)].mean())


def _by_run(runs: Runs) -> list[list[float]]:
    """Seed, noise, lost beams and error of each run."""
    table: list[list[float]] = np.column_stack([runs.seed, runs.noise, runs.drop, runs.error]).tolist()
    return table


def summary(runs: Runs, simulator: str) -> str:
    """Describe the results."""
    seeds, reached = len(np.unique(runs.seed)), int(runs.reached.sum())
    text = io.StringIO()
    print(f"{len(runs.error)} runs in {simulator}, {seeds} for each pair of noise and lost beams", file=text)
    bounds = fixed_bounds(reached, len(runs.error))
    print(f"goal reached in {reached} of {len(runs.error)} ({bounds.low:.1%} to {bounds.high:.1%})", file=text)
    for name, values in (("noise", runs.noise), ("lost beams", runs.drop)):
        found = spearmanr(values, runs.error)
        print(
            f"Spearman correlation of error and {name}: {found.statistic:+.3f} (p = {found.pvalue:.1e})", file=text
        )
    drops = [float(drop) for drop in np.unique(runs.drop)[1:]]
    noises = [None, *(float(noise) for noise in np.unique(runs.noise))]
    cases = [(drop, noise) for drop in drops for noise in noises]
    ratios = [log_ratios(runs, *case) for case in cases]
    effects = [effect(each) for each in ratios]
    kept = f"of {RESAMPLES} resamples of the seeds"
    print(f"noise makes the error larger in {survivals(noise_effect(runs))} {kept}", file=text)
    if cases:
        print("error with lost beams by that without, in pairs of one seed and noise:", file=text)
    adjusted = adjust([each.p for each in effects])
    for (drop, noise), values, each, p in zip(cases, ratios, effects, adjusted, strict=True):
        at = "all noises" if noise is None else f"noise {noise:.1f} m"
        print(
            f"  {drop:4.0%}, {at:11}: {each.ratio.mean:.2f} ({each.ratio.low:.2f} to {each.ratio.high:.2f}); "
            f"larger for {each.growing} and smaller for {each.falling} seeds, p = {p:.1e}; "
            f"interval without 1 in {survivals(values)} {kept}",
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
    """Draw the heat map, the curve over noise, and the effect of lost beams."""
    figure = Figure(figsize=(13.0, 4.6), dpi=90, facecolor="white")
    heat, by_noise, by_drop = figure.subplots(1, 3, width_ratios=(1.25, 1.0, 1.0))
    _draw_heat(figure, heat, runs)
    _draw_noise(by_noise, runs)
    _draw_effect(by_drop, runs)
    for axes in (by_noise, by_drop):
        axes.grid(color="#e6e3dc", linewidth=0.7)
        axes.set_axisbelow(True)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        axes.legend(frameon=False, fontsize=9, loc="upper left" if axes is by_noise else "lower left")
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


def _draw_noise(axes: Axes, runs: Runs) -> None:
    """The error along the noise, over all shares of lost beams and for each seed."""
    values = np.unique(runs.noise)
    for seed in np.unique(runs.seed):
        axes.plot(values, [_of(runs, seed, value) for value in values], color=PALE, linewidth=0.7, zorder=1)
    _draw_band(axes, values, [over_seeds(runs, runs.noise == value) for value in values], LINE, "mean")
    axes.set(xlabel="noise of ranges, standard deviation [m]", ylim=(0.0, None))
    axes.set_ylabel("error of the localisation [m]", color=INK)
    axes.set_title("by noise; grey: each seed", fontsize=11, color=INK)


def _draw_effect(axes: Axes, runs: Runs) -> None:
    """The factor of the error by lost beams along the noise, over seeds."""
    noises = np.unique(runs.noise)
    for drop, colour in zip(np.unique(runs.drop)[1:], cycle((LINE, "#c2571a", "#3f8f4f")), strict=False):
        ratios = [effect(log_ratios(runs, float(drop), float(noise))).ratio for noise in noises]
        _draw_band(axes, noises, ratios, colour, f"{drop:.0%} of the beams lost")
    axes.axhline(1.0, color=INK, linewidth=0.8, linestyle=":")
    axes.set(xlabel="noise of ranges, standard deviation [m]")
    axes.set_ylabel("error by that of equal runs without lost beams", color=INK)
    axes.set_title("effect of lost beams", fontsize=11, color=INK)


def _draw_band(axes: Axes, values: np.ndarray, found: Sequence[Estimate], colour: str, label: str) -> None:
    low, high = [each.low for each in found], [each.high for each in found]
    axes.fill_between(values, low, high, color=colour, alpha=0.3, linewidth=0, zorder=2)
    label = f"{label}, {LEVEL:.0%} interval"
    axes.plot(values, [each.mean for each in found], "o-", color=colour, linewidth=2.2, zorder=3, label=label)


def main(arguments: Sequence[str] | None = None) -> int:
    """Analyse campaigns; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER", help="the folder of a campaign")
    parser.add_argument("--simulator", default="MuJoCo", metavar="NAME", help="for titles (default: %(default)s)")
    options = parser.parse_args(arguments)
    try:
        runs = read(*(folder / TABLE for folder in options.folders))
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    text = summary(runs, options.simulator)
    print(text, end="")
    (options.folders[0] / "localisation.txt").write_text(text, encoding="utf-8")
    write_cells(runs, options.folders[0] / "localisation.csv")
    draw(runs, options.simulator, options.folders[0] / "localisation.png")
    for kind in ("png", "csv", "txt"):
        print(f"  {options.folders[0] / 'localisation'}.{kind}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
