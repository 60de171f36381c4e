"""Sobol sequence: points that fill the space more evenly than random ones, at any number of them.

Scrambled by the seed (Owen, "Scrambling Sobol' and Niederreiter-Xing points", 1998), by `scipy.stats.qmc`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Final, Protocol

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.errors import UsageError
from seoro.lang.frozen import Value

BATCH: Final = 64  # points made at a time; the sequence is balanced after powers of two
BITS: Final = 53  # of each number, those of a float


class _Numbers(Protocol):
    """Array of numpy."""

    def tolist(self) -> list[list[float]]:
        """Return lists of the numbers of each point."""


class _Sequence(Protocol):
    """Sequence of scipy."""

    def random(self, n: int) -> _Numbers:
        """Return the next points."""


class Sobol(Value):
    """Scrambled Sobol sequence, without an end."""

    name = "sobol"
    is_learning = False
    is_endless = True
    sampling = Sampling.SPREAD
    helps: ClassVar[Mapping[str, str]] = {}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the points; see `Strategy`."""
        try:
            from scipy.stats import qmc  # noqa: PLC0415 - an extra
        except ImportError:
            raise UsageError(
                "the strategy `sobol` needs scipy",
                help="pip install 'seoro[node]', or choose `--strategy latin`, which needs nothing",
            ) from None
        dimensions = max(1, len(space.axes))
        if dimensions > qmc.Sobol.MAXDIM:
            raise UsageError(
                f"the strategy `sobol` has at most {qmc.Sobol.MAXDIM:,} parameters, not {dimensions:,}"
            )
        return self._batches(space.axes, qmc.Sobol(dimensions, scramble=True, bits=BITS, seed=seed))

    def _batches(self, axes: Sequence[Axis], sequence: _Sequence) -> Batches:
        while True:
            shares = sequence.random(BATCH).tolist()
            yield [
                Point({axis.path: axis.at(share) for axis, share in zip(axes, each, strict=False)})
                for each in shares
            ]
