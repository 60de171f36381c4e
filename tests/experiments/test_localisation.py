"""The analysis of the experiment on faults of a lidar, on synthetic tables."""

from __future__ import annotations

import csv
import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "localisation_experiment.py"


@pytest.fixture(scope="module")
def analysis() -> ModuleType:
    pytest.importorskip("matplotlib")
    spec = importlib.util.spec_from_file_location("localisation_experiment", SCRIPT)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, spec.name, module)  # dataclasses look their module up
        spec.loader.exec_module(module)
    return module


def write(folder: Path, *, measured: bool = True) -> None:
    """Write errors that grow with the noise, not with the lost beams, and differ by seed."""
    names = ["noise.parameter_value", "drop.parameter_value", "turtlebot4.localisation_error"]
    with (folder / "runs.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["run", "seed", "reason", *names, "turtlebot4.goals_reached"])
        number = 0
        for noise in (0.0, 0.1, 0.2):
            for drop in (0.0, 0.5):
                for seed in (0, 1, 2):
                    number += 1
                    value = 0.01 + noise + 0.001 * seed if measured else ""
                    writer.writerow([number, seed, "", noise, drop, value, int(noise < 0.2)])


def test_confidence_intervals_refer_to_the_mean_over_seeds(analysis: ModuleType, tmp_path: Path) -> None:
    write(tmp_path)
    runs = analysis.read(tmp_path / "runs.csv")
    found = analysis.over_seeds(runs, runs.noise == 0.1)
    assert found.mean == pytest.approx(0.111)
    half = 4.3027 * 0.001 / math.sqrt(3.0)  # Student's t with 2 degrees of freedom
    assert (found.low, found.high) == pytest.approx((0.111 - half, 0.111 + half), abs=1e-6)
    single = analysis.over_seeds(runs, (runs.noise == 0.1) & (runs.seed == 0))
    assert math.isnan(single.low)


def test_the_analysis_writes_a_plot_a_table_and_a_summary(
    analysis: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path)
    assert analysis.main([str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "18 runs in MuJoCo, 3 for each pair" in printed
    assert "goal reached in 12 of 18" in printed
    assert "error and noise: +0.9" in printed
    assert "error and lost beams: +0.0" in printed
    assert printed.startswith((tmp_path / "localisation.txt").read_text(encoding="utf-8"))
    with (tmp_path / "localisation.csv").open(newline="", encoding="utf-8") as file:
        cells = list(csv.DictReader(file))
    assert len(cells) == 6
    assert cells[-1]["error"] == "0.2110" and cells[-1]["reached"] == "0.0"
    assert (tmp_path / "localisation.png").read_bytes().startswith(b"\x89PNG")


def test_a_run_without_a_localisation_error_is_reported(
    analysis: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, measured=False)
    assert analysis.main([str(tmp_path)]) == 2
    assert "run 1 of" in capsys.readouterr().err
    assert analysis.main([str(tmp_path / "nowhere")]) == 2


def test_the_effect_of_lost_beams_is_measured_by_paired_runs(analysis: ModuleType, tmp_path: Path) -> None:
    """The error is a tenth larger in every pair, which the noise hides from a correlation over all runs."""
    write(tmp_path)
    runs = analysis.read(tmp_path / "runs.csv")
    worse = replace(runs, error=np.where(runs.drop > 0.0, 1.1, 1.0) * runs.error)
    found = analysis.effect(analysis.log_ratios(worse, 0.5))
    assert (found.ratio.mean, found.ratio.low, found.ratio.high) == pytest.approx((1.1, 1.1, 1.1))
    assert (found.growing, found.falling, found.p) == (3, 0, pytest.approx(2.0 / 2**3)), "seeds are independent"
    assert analysis.spearmanr(worse.drop, worse.error).pvalue > 0.1
    same = analysis.effect(analysis.log_ratios(runs, 0.5))
    assert (same.ratio.mean, same.p) == (pytest.approx(1.0), 1.0)


def test_conclusions_are_tested_again_in_resamples_of_the_seeds(analysis: ModuleType, tmp_path: Path) -> None:
    write(tmp_path)
    runs = analysis.read(tmp_path / "runs.csv")
    assert analysis.survivals(analysis.noise_effect(runs)) == 20
    assert analysis.survivals(np.array([-0.09, -0.1, -0.11] * 10)) == 20, "also of a smaller error"
    assert analysis.survivals(np.array([-1.0, 0.1, 1.0] * 10)) < 5


def test_the_effect_of_lost_beams_may_depend_on_the_noise(analysis: ModuleType, tmp_path: Path) -> None:
    write(tmp_path)
    runs = analysis.read(tmp_path / "runs.csv")
    factor = np.where((runs.drop > 0.0) & (runs.noise == 0.2), 2.0, 1.0)
    worse = replace(runs, error=factor * runs.error)
    assert analysis.effect(analysis.log_ratios(worse, 0.5, 0.1)).ratio.mean == pytest.approx(1.0)
    assert analysis.effect(analysis.log_ratios(worse, 0.5, 0.2)).ratio.mean == pytest.approx(2.0)
    assert "50%, noise 0.2 m: 2.00" in analysis.summary(worse, "MuJoCo")


def test_campaigns_with_other_seeds_are_read_together(analysis: ModuleType, tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write(tmp_path / name)
    runs = analysis.read(tmp_path / "a" / "runs.csv", tmp_path / "b" / "runs.csv")
    assert len(runs.error) == 36
