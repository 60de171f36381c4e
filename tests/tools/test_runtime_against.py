"""The comparison of the runtime with another checkout rejects checkouts that it cannot measure."""

import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def against(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    module = importlib.import_module("runtime_against")
    for name in ("runtime_against", "startup", "peer"):
        monkeypatch.delitem(sys.modules, name)
    return module


def test_a_checkout_needs_a_package(against: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="does not import seoro from"):
        against.check_checkout(tmp_path)


def test_a_checkout_precedes_installed_packages(against: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "seoro").mkdir()
    (tmp_path / "seoro" / "__init__.py").touch()
    against.check_checkout(tmp_path)
    assert against.environment(tmp_path)["PYTHONPATH"] == str(tmp_path)


@pytest.mark.parametrize(("ratio", "mark"), [(1.0, "MISSED"), (0.77, "must"), (0.5, "goal")])
def test_ratios_are_held_against_the_targets(against: ModuleType, ratio: float, mark: str) -> None:
    assert against.ROWS["side"].mark(ratio) == mark


@pytest.mark.parametrize(("ratio", "mark"), [(1.3, "MISSED"), (1.4, "must"), (2.1, "goal")])
def test_rates_have_to_grow(against: ModuleType, ratio: float, mark: str) -> None:
    assert against.ROWS["wakeups"].mark(ratio) == mark


def test_single_slow_rounds_do_not_count_in_times_of_the_wall_clock(against: ModuleType) -> None:
    assert against.ROWS["reaction"].ratio([1.0, 1.0, 9.0], [2.0, 2.0, 2.0]) == 2.0
    assert against.ROWS["side"].ratio([1.0, 9.0, 9.0], [2.0, 9.0, 9.0]) == 1.0
