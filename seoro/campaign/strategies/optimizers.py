"""Searches by samplers of Optuna: tree-structured Parzen estimators, and CMA-ES.

Bergstra, Bardenet, Bengio, Kégl, "Algorithms for hyper-parameter optimization", 2011.
Hansen, Ostermeier, "Completely derandomized self-adaptation in evolution strategies", 2001.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING, ClassVar, Final

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.objective import MAXIMIZE, MINIMIZE, Objective, objective_of
from seoro.campaign.strategies.shares import TRIES
from seoro.errors import UsageError
from seoro.lang.frozen import Value

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution
    from optuna.samplers import BaseSampler
    from optuna.study import Study
    from optuna.trial import Trial

BATCH: Final = 8  # points between two lessons
SEEDS: Final = 1 << 32  # of numpy
_WORST: Final = math.inf  # also of errors, so that they are avoided
HELPS: Final[Mapping[str, str]] = {
    "minimize": MINIMIZE,
    "maximize": MAXIMIZE,
    "batch": f"number of points between two lessons (default: {BATCH}, or the population of cmaes)",
}


class Tpe(Value):
    """Search by tree-structured Parzen estimators, for numbers and values without order.

    Args:
        minimize: Column that is small near failures; empty for `margin`.
        maximize: Column that is large near failures, instead.
        batch: Number of points between two lessons.
    """

    minimize: str = ""
    maximize: str = ""
    batch: int = BATCH
    name = "tpe"
    is_learning = True
    is_endless = True
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = HELPS

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        _check(space, self.name, self.batch, "optuna")
        from optuna.samplers import TPESampler  # noqa: PLC0415 - an extra

        sampler = TPESampler(seed=seed % SEEDS, constant_liar=True)
        return _batches(space, objective_of(self.minimize, self.maximize), sampler, self.batch)


class CmaEs(Value):
    """Search by an evolution strategy that adapts the covariance of its draws, for numbers.

    Args:
        minimize, maximize: As of `Tpe`.
        batch: Number of points between two lessons, and size of the population; 0 for the usual one.
    """

    minimize: str = ""
    maximize: str = ""
    batch: int = 0
    name = "cmaes"
    is_learning = True
    is_endless = True
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = HELPS

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        _check(space, self.name, self.batch or 1, "optuna", "cmaes")
        if all(isinstance(axis, Choices) and not axis.is_ascending for axis in space.axes):
            raise UsageError(
                f"the strategy `{self.name}` needs a parameter with numbers",
                space.axes[0].span,
                help="choose `--strategy tpe`",
            )
        from optuna.samplers import CmaEsSampler  # noqa: PLC0415 - an extra

        population = self.batch or 4 + int(3 * math.log(len(space.axes)))
        sampler = CmaEsSampler(seed=seed % SEEDS, warn_independent_sampling=False, popsize=max(population, 2))
        return _batches(space, objective_of(self.minimize, self.maximize), sampler, population)


def _check(space: Space, name: str, batch: int, *modules: str) -> None:
    """Raise `UsageError` if a search cannot begin."""
    if not space.axes:
        raise UsageError("a search needs a parameter that varies")
    if batch < 1:
        raise UsageError(f"expected at least 1 for `batch`, found {batch}")
    check_installed(name, *modules)


def check_installed(name: str, *modules: str) -> None:
    """Check that the packages of a strategy are installed.

    Raises:
        UsageError: One is missing.
    """
    for module in modules:
        if find_spec(module) is None:
            raise UsageError(
                f"the strategy `{name}` needs {module}",
                help="pip install 'seoro[search]', or choose `--strategy search`, which needs nothing",
            )


def _batches(space: Space, objective: Objective, sampler: BaseSampler, batch: int) -> Batches:
    import optuna  # noqa: PLC0415 - an extra

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study(sampler=sampler)
    distributions = {axis.path: _distribution(axis) for axis in space.axes}
    is_known = False
    while True:
        asked = [_ask(study, distributions, space) for _ in range(batch)]
        told = yield [point for _, point in asked]
        for (trial, _), each in zip(asked, told, strict=True):
            value = objective.value(each)
            study.tell(trial, _WORST if value is None else value)
        is_known = is_known or objective.is_known(told)


def _ask(study: Study, distributions: Mapping[str, BaseDistribution], space: Space) -> tuple[Trial, Point]:
    """Ask for a point that constraints allow. Points that they exclude count as the worst, and cost no run."""
    for left in reversed(range(TRIES)):
        trial = study.ask(dict(distributions))
        point = Point({axis.path: _text(axis, trial.params[axis.path]) for axis in space.axes})
        if not left or space.is_feasible(point.values):
            break
        study.tell(trial, _WORST)
    return trial, point


def _distribution(axis: Axis) -> BaseDistribution:
    from optuna.distributions import (  # noqa: PLC0415 - an extra
        CategoricalDistribution,
        FloatDistribution,
        IntDistribution,
    )

    if isinstance(axis, Choices):
        last = len(axis.texts) - 1
        return IntDistribution(0, last) if axis.is_ascending else CategoricalDistribution(range(last + 1))
    if axis.is_whole:
        return IntDistribution(int(axis.low), int(axis.high))
    return FloatDistribution(axis.low, axis.high)


def _text(axis: Axis, value: float) -> str:
    return axis.texts[int(value)] if isinstance(axis, Choices) else axis.text(value)
