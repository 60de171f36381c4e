"""Actions of `osc.helpers` with known effects: `log`, `increment`, `decrement` and `compare`.

They take no time. `log` writes one record with the text of its argument. `increment` and `decrement` change a
variable once by one. `compare` fails exactly if its relation is false; the others always succeed. An action
cancelled in the instant in which it starts may or may not have had its effect.
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from seoro.lang.plan import Action, InvokeAction, ValueType
from seoro.lang.source import Span
from seoro.runtime.accept.findings import Rule
from seoro.runtime.accept.fitting import same
from seoro.runtime.accept.frames import FAILED, SUCCEEDED, Checker, End, Frame, Matched
from seoro.runtime.accept.history import LoggedEvent
from seoro.runtime.accept.instances import Instance
from seoro.runtime.values.comparison import RELATIONS, NotComparable, compare_values
from seoro.runtime.values.conversions import wrapped
from seoro.runtime.values.text import message_text, value_text

_LIBRARY: Final = "osc.helpers"
_STEPS: Final = {"increment": 1, "decrement": -1}
_NAMES: Final = frozenset({"log", "compare", *_STEPS})


@dataclass(eq=False)
class _Effects:
    """Numbers of required and of possible effects.

    Args:
        span: Place of the invocation.
    """

    span: Span
    required: Counter[tuple[float, str]] = field(default_factory=Counter)
    possible: Counter[tuple[float, str]] = field(default_factory=Counter)

    def expect(self, t: float, what: str, is_certain: bool) -> None:
        """Note an expected effect at a time."""
        self.possible[t, what] += 1
        if is_certain:
            self.required[t, what] += 1


@dataclass(eq=False)
class ActionChecker(Checker):
    """Check of the effects of these actions."""

    _logs: dict[str, _Effects] = field(default_factory=dict)  # by place of the invocation
    _changes: dict[int, _Effects] = field(default_factory=dict)  # by number of the behavior

    def check(self, matched: Matched) -> None:
        """Check all of these actions."""
        for instance, frame in matched.executions:
            declared = instance.declaration
            invocation = matched.plans.get(frame.owner.number)
            is_one = isinstance(declared, Action) and declared.library == _LIBRARY and declared.name in _NAMES
            if is_one and isinstance(invocation, InvokeAction):
                self._check(invocation, instance, frame)
        self._check_logs()
        self._check_changes()

    def _check(self, invocation: InvokeAction, instance: Instance, frame: Frame) -> None:
        name, t = instance.declaration.name, frame.start.t
        status = SUCCEEDED
        is_certain = frame.status == SUCCEEDED and SUCCEEDED not in frame.cuts
        self.world.present.seq = instance.seq
        if name == "log":
            effects = self._logs.setdefault(str(invocation.span), _Effects(invocation.span))
            value = instance.fields["msg"]
            type_ = self._type(invocation, instance, "msg")
            effects.expect(t, message_text(value, type_, self.world.plan.structures), is_certain)
        elif name == "compare":
            status = self._compared(invocation, instance)
        else:
            effects = self._changes.setdefault(frame.owner.number, _Effects(invocation.span))
            effects.expect(t, name, is_certain)
        self.check_end(frame, End(status, t), Rule.ACTION, invocation.span)

    def _compared(self, invocation: InvokeAction, instance: Instance) -> str:
        """Return the expected status of a `compare`."""
        fields = instance.fields
        left, right = (self._type(invocation, instance, name) for name in ("left_value", "right_value"))
        operator = str(fields["operator"])
        holds = False
        with suppress(NotComparable):
            if operator in RELATIONS:
                holds = compare_values(fields["left_value"], left, operator, fields["right_value"], right)
        return SUCCEEDED if holds else FAILED

    def _type(self, invocation: InvokeAction, instance: Instance, parameter: str) -> ValueType | None:
        """Return the static type of an argument; None if unknown."""
        types = dict(invocation.types)
        if parameter in types or parameter in dict(invocation.arguments):
            return types.get(parameter)
        return instance.declaration.structure.fields[parameter].type

    def _check_logs(self) -> None:
        written: dict[str, Counter[tuple[float, str]]] = {source: Counter() for source in self._logs}
        for record in self.history.records:
            source = record.get("source")
            if record["kind"] != "log" or record.get("level") != "info" or source not in self._logs:
                continue
            text, effects = str(record.get("message")), self._logs[source]
            written[source][record["t"], text] += 1
            if written[source][record["t"], text] > effects.possible[record["t"], text]:
                message = f"`{_short(text)}` is logged, but no `log` writes it then"
                self.findings.violate(Rule.ACTION, message, effects.span, record["seq"])
        for source, effects in self._logs.items():
            for t, text in effects.required - written[source]:
                message = f"`{_short(text)}` is not logged at {t:g} s"
                self.findings.violate(Rule.ACTION, message, effects.span)

    def _check_changes(self) -> None:
        made: dict[int, Counter[float]] = {number: Counter() for number in self._changes}
        for change in (change for found in self.history.changes.values() for change in found):
            node = self.history.nodes.get(change.recorded.get("by", -1))
            number = node.owner.number if node is not None else -1  # the writer may be a modifier of the action
            if number not in self._changes:
                continue
            effects = self._changes[number]
            name = next(name for _, name in effects.possible)
            made[number][change.mark.t] += 1
            if made[number][change.mark.t] > effects.possible[change.mark.t, name]:
                message = f"`{change.name}` changes, but `{name}` does not change it then"
                self.findings.violate(Rule.ACTION, message, effects.span, change.mark.seq)
            self._check_step(change, name, effects.span)
        for number, effects in self._changes.items():
            for (t, name), count in effects.required.items():
                if made[number][t] < count:
                    message = f"`{name}` changes nothing at {t:g} s"
                    self.findings.violate(Rule.ACTION, message, effects.span, self.history.nodes[number].start.seq)

    def _check_step(self, change: LoggedEvent, name: str, span: Span) -> None:
        """Check that the new value is one more, or one less, than the old one."""
        holder = self.world.holder(change.of)
        declared = self.world.declared(holder, change.name) if holder is not None else None
        if holder is None or declared is None:
            return  # reported with the variable
        self.world.present.seq = change.mark.seq
        with self.findings.undecided(Rule.ACTION, span, KeyError):
            recorded, before = self.world.decode(change.recorded.get("exact")), holder.fields[change.name]
            if not isinstance(before, int | float):
                return  # reported with the variable
            expected = wrapped(before + _STEPS[name], declared.type)
            if not same(recorded, expected):
                structures = self.world.plan.structures
                shown, needed = (value_text(each, declared.type, structures) for each in (recorded, expected))
                message = f"`{name}` changes `{change.name}` to {shown}; expected {needed}"
                self.findings.violate(Rule.ACTION, message, span, change.mark.seq)


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
