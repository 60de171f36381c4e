"""State of the world over time: instances, structs and actors, with the values of their fields.

Expressions are evaluated at a record of the trace: a variable has the value of its last change before. Calls of
external methods and random values cannot be evaluated from a trace.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any, cast

from seoro.lang import plan as plan_
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.fitting import is_plain_form
from seoro.runtime.accept.history import History, LoggedEvent, Record
from seoro.runtime.accept.instances import Instance, Present, TimedFields
from seoro.runtime.accept.layers import overrides_in
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.values.environment import Environment, EvaluationError, NotInvoked, Reads
from seoro.runtime.values.values import Actor, HasFields, Range, Struct, Value, Variable


class NothingInvoked(Undecided):
    """A label in an expression has not been invoked yet."""


class World:
    """Instances and values of a trace.

    Args:
        plan: The plan.
        history: The trace.
        findings: Collects contradictions.
    """

    def __init__(self, plan: plan_.Plan, history: History, findings: Findings) -> None:
        self.plan = plan
        self.history = history
        self.findings = findings
        self.overridden = frozenset(each.overridden[-1] for each in overrides_in(plan))
        self.present = Present()
        self.instances: dict[int, Instance] = {}
        self.objects: dict[int, Struct | Actor] = {}
        self.recorded: list[tuple[Struct | Actor, int]] = []  # with their records
        self._numbers: dict[int, int] = {}
        self._of_modifiers = {name for modifier in plan.modifiers.values() for name in modifier.structure.fields}
        self._undecidable: dict[int, tuple[plan_.Expression, str | None]] = {}
        logged = chain(*history.changes.values(), *history.events.values())
        logged_by_seq = {each.mark.seq: each for each in logged}
        self.arguments: dict[int, dict[str, Value]] = {}  # of events, by record
        instances = {record["seq"] for record in history.instances}
        for seq, record in enumerate(history.records):
            self.present.seq = seq
            self._load(record, seq in instances, logged_by_seq.get(seq))

    # -------------------------------------------------------- reading the trace

    def _load(self, record: Record, is_instance: bool, logged: LoggedEvent | None) -> None:
        try:
            if is_instance:
                self._load_instance(record)
            elif logged is not None and record["kind"] == "variable":
                self._load_change(logged)
            elif logged is not None:
                recorded = record.get("exact") or {}
                arguments = {name: self.decode(value) for name, value in recorded.items()}
                self.arguments[record["seq"]] = arguments
                self._compare_with_exact("arguments", record, arguments)
            elif record["kind"] == "behavior.start" and isinstance(record.get("arguments"), dict):
                for value in record["arguments"].values():
                    self.decode(value)  # for objects that first occur here
        except (Undecided, KeyError, TypeError, ValueError, AttributeError) as error:
            self.findings.violate(Rule.STRUCTURE, f"cannot read a value: {error}", None, record["seq"])

    def _load_instance(self, record: Record) -> None:
        name, number = record["of"], record["instance"]
        declared = self.plan.scenarios.get(name) or self.plan.actions.get(name)
        if declared is None:
            self.findings.violate(
                Rule.TREE, f"`{name}` is invoked, but is missing in the scenario", None, record["seq"]
            )
            return
        if number in self.instances or number in self.objects:
            self.findings.violate(Rule.STRUCTURE, f"duplicate instance {number}", None, record["seq"])
        fields = TimedFields(self.present)
        actor = self.decode(record["actor"]) if "actor" in record else None
        for field_name, value in record["values"].items():
            dict.__setitem__(fields, field_name, self.decode(value))
        made = Instance(
            declared, number, record, fields, actor if isinstance(actor, Actor) else None, self.present, self.plan
        )
        self.instances[number] = made
        self._numbers[id(made)] = number

    def _load_change(self, change: LoggedEvent) -> None:
        holder = self.holder(change.of)
        if holder is None and change.name in self._of_modifiers:
            return
        if holder is None:
            raise Undecided(f"unknown instance {change.of}")
        value = self.decode(change.recorded["exact"])
        self._compare_with_exact("value", change.recorded, value)
        cast(TimedFields, holder.fields).change(change.name, change.mark.seq, value)

    def _compare_with_exact(self, name: str, record: Record, exact: Value | Mapping[str, Value]) -> None:
        """Check that the plain and the exact values of a record are equal."""
        if not is_plain_form(record.get(name), exact):
            message = f"`{name}` and `exact` of a record differ"
            self.findings.violate(Rule.STRUCTURE, message, None, self.present.seq)

    def decode(self, recorded: object) -> Value:
        """Decode an exact value of the trace.

        Raises:
            Undecided: It refers to an unknown instance.
        """
        match recorded:
            case bool() | int() | float() | str():
                return recorded
            case list():
                return tuple(self.decode(item) for item in recorded)
            case {"enum": str(type_name), "member": str(member), "number": int(number)}:
                return plan_.EnumValue(type_name, member, number)
            case {"float": "nan" | "inf" | "-inf" as text}:
                return float(text)
            case {"low": int() | float() as low, "high": int() | float() as high}:
                return Range(low, high)
            case {"object": int(number), "types": list(types), "fields": dict(fields)}:
                return self._object(number, types, fields, cast(Record, recorded).get("actor"))
            case {"object": int(number)} if number in self.objects:
                return self.objects[number]
            case {"variable": str(name), "of": dict(of)}:
                holder = self.instances.get(of["object"]) or cast(HasFields, self.decode(of))
                return Variable(holder, name, cast(Any, None), name)
            case _:
                raise Undecided(f"unknown instance {recorded!r}")

    def _object(self, number: int, types: list[str], fields: Record, actor: object) -> Struct | Actor:
        if number in self.objects or number in self.instances:
            self.findings.violate(Rule.STRUCTURE, f"duplicate instance {number}", None, self.present.seq)
        known = {structure.type.name: structure.type for structure in self.plan.structures.all()}
        for index, name in enumerate(types):
            type_ = known.get(name)
            if type_ is not None and [name, *type_.bases] == types[index:]:
                break
        else:
            raise Undecided(f"unknown type {' of '.join(types[:1])!r}")
        made = (
            Actor(cast(Any, type_), str(actor), TimedFields(self.present), types[:index])
            if actor is not None
            else Struct(cast(Any, type_), TimedFields(self.present), types[:index])
        )
        self.objects[number] = made
        self.recorded.append((made, self.present.seq))
        self._numbers[id(made)] = number
        for name, value in fields.items():
            dict.__setitem__(made.fields, name, self.decode(value))
        return made

    def holder(self, number: int) -> Instance | Struct | Actor | None:
        """Return the instance, struct or actor of a number."""
        return self.instances.get(number) or self.objects.get(number)

    def next_instance(self, seq: int) -> list[int]:
        """Return the record of the first instance at or after a record, if any."""
        index = bisect_left(self.history.instances, seq, key=lambda record: int(record["seq"]))
        return [int(record["seq"]) for record in self.history.instances[index : index + 1]]

    def instances_before(self, seq: int, t: float) -> list[int]:
        """Return the records of instances before a record, in one instant."""
        records = self.history.instances
        last = bisect_left(records, seq, key=lambda record: int(record["seq"]))
        first = bisect_left(records, t, hi=last, key=lambda record: float(record["t"]))
        return [int(record["seq"]) for record in records[first:last]]

    def number(self, holder: object) -> int | None:
        """Return the number of an instance; None if unknown."""
        return self._numbers.get(id(holder))

    def scope_of(self, holder: HasFields, around: Environment) -> Environment:
        """Return the environment of an instance's scope, seen from another scope."""
        if isinstance(holder, Instance):
            return holder.environment
        return replace(around, instance=holder, bindings={}, scenario=around.outermost)

    def declared(self, holder: Instance | Struct | Actor, name: str) -> plan_.FieldDeclaration | None:
        """Return the declaration of a field of an instance."""
        if isinstance(holder, Instance):
            return holder.declaration.structure.fields.get(name) or self.plan.globals.fields.get(name)
        structure = self.plan.structures.of(holder.type)
        latent = [member for each in structure.latents if each.type in holder.latent for member in each.members]
        fields = {member.name: member for member in latent if isinstance(member, plan_.FieldDeclaration)}
        return structure.fields.get(name) or fields.get(name)

    def declaration_of(self, holder: HasFields) -> plan_.Scenario | plan_.Action | plan_.ObjectType | None:
        """Return the declaration of an instance, a struct or an actor; None if unknown."""
        if isinstance(holder, Instance):
            return holder.declaration
        return self.plan.object_type(holder.types) if isinstance(holder, Struct | Actor) else None

    def samples_of(self, holder: Instance | Struct | Actor) -> tuple[plan_.Sample, ...]:
        """Return the sampled variables of a holder."""
        declared = self.declaration_of(holder)
        return declared.samples if declared is not None else ()

    # -------------------------------------------------------- expressions

    def value(
        self, expression: plan_.Expression, environment: Environment, seq: int, reads: Reads | None = None
    ) -> Value:
        """Evaluate an expression as of a record.

        Raises:
            Undecided: The trace lacks the data.
        """
        reason = self._why_undecidable(expression)
        if reason is not None:
            raise Undecided(reason)
        self.present.seq = seq
        try:
            return evaluate(expression, replace(environment, reads=reads))
        except NotInvoked as error:
            raise NothingInvoked(str(error)) from None
        except EvaluationError as error:
            raise Undecided(f"`{_short(expression)}` has no value: {error}") from None
        except (KeyError, AssertionError, AttributeError, TypeError, IndexError, RecursionError):
            raise Undecided(f"the trace has no value for `{_short(expression)}`") from None

    def _why_undecidable(self, expression: plan_.Expression) -> str | None:
        known = self._undecidable.get(id(expression))
        if known is None:
            reasons = map(self._why_not, walk_calls(expression, self.plan.methods))
            reason = next(filter(None, reasons), None)
            known = self._undecidable[id(expression)] = (expression, reason)  # kept, so that the id stays unique
        return known[1]

    def _why_not(self, part: plan_.Expression) -> str | None:
        match part:
            case plan_.Call(method=name):
                external = next(
                    (m for m in self.plan.methods.named(name) if isinstance(m.body, plan_.External)), None
                )
                if external is not None:
                    return f"`{external.name}` is an external method, whose results are not in the trace"
            case plan_.Construct(type=type_) if not self.plan.structures.of(type_).is_plain:
                return f"a value of `{type_.name}` is chosen where it is constructed"
            case _:
                pass
        return None


def walk_calls(expression: plan_.Expression, methods: plan_.Methods) -> Iterator[plan_.Expression]:
    """Yield an expression with all of its parts, including the bodies of called methods."""
    pending, seen = [expression], set()
    while pending:
        part = pending.pop()
        yield part
        pending += plan_.parts(part)
        if isinstance(part, plan_.Call) and part.method not in seen:
            seen.add(part.method)
            bodies = (method.body for method in methods.named(part.method))
            pending += [body for body in bodies if isinstance(body, plan_.Expression)]


def has_labels(expression: plan_.Expression, methods: plan_.Methods) -> bool:
    """Whether an expression depends on invocations under labels."""
    return any(isinstance(part, plan_.Labelled) for part in walk_calls(expression, methods))


def _short(expression: plan_.Expression) -> str:
    return " ".join(expression.span.text.split())
