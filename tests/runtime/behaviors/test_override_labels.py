"""`override` as a registry of labels, without a scheduler: which behavior ends, or does not start."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest

from seoro.lang.plan import Override, OverrideMode
from seoro.runtime.behaviors.override import end_labelled, is_overridden, start_labelled
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.execution.services import Overriding
from seoro.runtime.instances.instances import Instance
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.values.values import Fields
from seoro.runtime.verdict import Outcome, Status
from tests.runtime.behaviors.groups import SPAN


class Scope:
    """A fake scope of a labelled behavior."""

    def __init__(self) -> None:
        self.outcome: Outcome | None = None

    @property
    def is_cancelled(self) -> bool:
        return self.outcome is not None

    def cancel(self, outcome: Outcome) -> None:
        self.outcome = outcome


class Labels:
    """Labelled behaviors of a scenario; one overrides another."""

    def __init__(self, mode: OverrideMode, overridden: str = "drive") -> None:
        self.instance = Instance("main", Fields(), cast(Any, None), {})
        self._mode = mode
        self._effects: list[tuple[int, Callable[[], None]]] = []
        self._overriding: dict[Overriding, None] = {}
        self.override(overridden, "stop")

    def override(self, overridden: str, by: str) -> None:
        """Register an override of a behavior by another."""
        plan = Override(tuple(overridden.split(".")), tuple(by.split(".")), self._mode, SPAN)
        self._overriding[Overriding(plan, self.instance)] = None

    def context(self, instance: Instance | None = None) -> ExecutionContext:
        scheduler = SimpleNamespace(
            write=lambda path, effect: self._effects.append((0, effect)),
            at_commit=lambda path, effect, cause: self._effects.append((1, effect)),
        )
        instance = self.instance if instance is None else instance
        services = SimpleNamespace(overriding=self._overriding)
        task = SimpleNamespace(past=CausalPast())
        fake = SimpleNamespace(services=services, scheduler=scheduler, instance=instance, position=(), task=task)
        return cast(ExecutionContext, fake)

    def start(self, label: str, instance: Instance | None = None) -> Scope:
        """Start a labelled behavior, in this delta cycle."""
        scope = Scope()
        start_labelled(label, self.context(instance), cast(CancelScope, scope))
        return scope

    def end(self, label: str, scope: Scope) -> None:
        end_labelled(label, self.context(), cast(CancelScope, scope))

    def commit(self) -> None:
        """Begin the next delta cycle."""
        effects, self._effects = sorted(self._effects, key=lambda each: each[0]), []
        for _, effect in effects:
            effect()


@pytest.mark.parametrize("mode", OverrideMode)
def test_a_behavior_ends_when_another_one_starts(mode: OverrideMode) -> None:
    labels = Labels(mode)
    drive = labels.start("drive")
    labels.commit()
    other = labels.start("other")
    labels.commit()
    assert not drive.is_cancelled
    stop = labels.start("stop")
    assert not drive.is_cancelled  # in the next delta cycle
    labels.commit()
    assert drive.outcome == Outcome(Status.CANCELLED, "overridden by `stop`", SPAN)
    assert not other.is_cancelled and not stop.is_cancelled


def test_a_behavior_that_has_ended_is_not_overridden() -> None:
    labels = Labels(OverrideMode.ON_START)
    drive = labels.start("drive")
    labels.commit()
    labels.end("drive", drive)
    labels.commit()
    labels.start("stop")
    labels.commit()
    assert not drive.is_cancelled


def test_the_end_of_an_earlier_behavior_keeps_a_later_one_registered() -> None:
    labels = Labels(OverrideMode.ON_START)
    first, second = labels.start("drive"), labels.start("drive")
    labels.commit()
    labels.end("drive", first)
    labels.commit()
    labels.start("stop")
    labels.commit()
    assert second.is_cancelled


def test_when_active_prevents_a_start_while_the_other_is_active() -> None:
    labels = Labels(OverrideMode.WHEN_ACTIVE)
    assert is_overridden("drive", labels.context()) is None
    stop = labels.start("stop")
    labels.commit()
    overridden = is_overridden("drive", labels.context())
    assert overridden is not None and not overridden.has_begun
    assert is_overridden("stop", labels.context()) is None
    labels.end("stop", stop)
    labels.commit()
    assert is_overridden("drive", labels.context()) is None


def test_on_start_does_not_prevent_a_start() -> None:
    labels = Labels(OverrideMode.ON_START)
    labels.start("stop")
    labels.commit()
    assert is_overridden("drive", labels.context()) is None


def test_the_first_of_two_mutual_overrides_continues() -> None:
    labels = Labels(OverrideMode.ON_START)
    labels.override("stop", "drive")
    drive, stop = labels.start("drive"), labels.start("stop")
    labels.commit()
    assert (drive.is_cancelled, stop.is_cancelled) == (False, True)


def test_a_path_leads_to_a_label_of_the_last_invocation() -> None:
    labels = Labels(OverrideMode.ON_START, overridden="inner.drive")
    inner, other = (Instance(name, Fields(), cast(Any, None), {}) for name in ("inner", "other"))
    labels.instance.latest("inner").set(inner)
    drive, elsewhere = labels.start("drive", inner), labels.start("drive", other)
    labels.commit()
    labels.start("stop")
    labels.commit()
    assert (drive.is_cancelled, elsewhere.is_cancelled) == (True, False)
