"""Variables change by what may change them, and hold values of their types (7.3.6.1.2)."""

from __future__ import annotations

from dataclasses import dataclass

from seoro.lang.plan import FieldDeclaration
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.fitting import fits
from seoro.runtime.accept.history import Happening, History, Node
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.values import Actor, Struct, Variable, plain


@dataclass(eq=False)
class Variables:
    """Checks changes of variables.

    Args:
        history: The trace.
        world: Its values.
        findings: Gets what is wrong.
    """

    history: History
    world: World
    findings: Findings

    def check(self) -> None:
        """Check all of them."""
        for (number, name), changes in self.history.changes.items():
            holder = self.world.holder(number)
            if holder is None:
                continue  # reported where it was read
            declared = self.world.declared(holder, name)
            for change in changes:
                self._check(holder, name, declared, change)

    def _check(
        self, holder: Instance | Struct | Actor, name: str, declared: FieldDeclaration | None, change: Happening
    ) -> None:
        seq = change.mark.seq
        if declared is None or not declared.is_variable:
            message = f"`{name}` changes, and is no variable"
            self.findings.violate(Rule.VARIABLE, message, declared.span if declared is not None else None, seq)
            return
        try:
            value = self.world.decode(change.told.get("exact"))
        except Undecided as why:
            self.findings.skip(Rule.VARIABLE, why, declared.span)
            return
        if not fits(value, declared.type):
            message = f"`{name}` takes the value {plain(value)!r}, which is not of its type"
            self.findings.violate(Rule.VARIABLE, message, declared.span, seq)
        node = self.history.nodes.get(change.told.get("by", -1))
        if node is None or node.start.seq > seq or node.end.t < change.mark.t:
            message = f"`{name}` changes at {change.mark.t:g} s, when what changes it does not run"
            self.findings.violate(Rule.VARIABLE, message, declared.span, seq)
        elif not (self._is_given(holder, name, node) or self._is_sampled(holder, name)):
            message = f"`{name}` is changed by `{node.name}`, which it is not given to"
            self.findings.violate(Rule.VARIABLE, message, declared.span, node.start.seq, seq)

    def _is_given(self, holder: Instance | Struct | Actor, name: str, node: Node) -> bool:
        """Whether an action was given the variable."""
        instances = (self.world.instances.get(number) for number in node.owner.instances)
        values = (value for each in instances if each is not None for value in each.fields.values())
        return any(
            isinstance(value, Variable) and value.holder is holder and value.name == name for value in values
        )

    def _is_sampled(self, holder: Instance | Struct | Actor, name: str) -> bool:
        return any(sample.field == name for sample in self.world.samples_of(holder))
