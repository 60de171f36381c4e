"""What there was while a trace was made: instances, structs and actors, with the values of their fields over time.

Expressions are evaluated at a record of the trace: a variable then has the value of its last change before that.
What calls an external method, or draws a value, cannot be evaluated from a trace.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import ItemsView, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

from seoro.lang.plan import (
    Action,
    Call,
    Construct,
    EnumValue,
    Expression,
    External,
    FieldDeclaration,
    Labelled,
    Plan,
    Sample,
    Scenario,
    behavior_type,
    parts,
)
from seoro.runtime.accept.findings import Findings, Rule, Undecided
from seoro.runtime.accept.fitting import is_plain_form
from seoro.runtime.accept.history import Happening, History, Record
from seoro.runtime.environment import Environment, EvaluationError, NotInvoked, Reads
from seoro.runtime.evaluate import evaluate
from seoro.runtime.values import Actor, HasFields, Range, Struct, Value, Variable

if TYPE_CHECKING:
    from seoro.runtime.accept.history import Node


class NothingInvoked(Undecided):
    """Nothing had been invoked under a label that an expression names."""


@dataclass(eq=False)
class Present:
    """The record at which expressions are evaluated at present."""

    seq: int = 0


class TimedFields(dict[str, Value]):
    """Fields by name, as they were at a place of the trace; a `dict`, since that is what structs hold.

    Args:
        present: The place at which they are asked for.
    """

    def __init__(self, present: Present) -> None:
        super().__init__()
        self._present = present
        self._changes: dict[str, tuple[list[int], list[Value]]] = {}

    def change(self, name: str, seq: int, value: Value) -> None:
        """Take in a change, in the order of the trace."""
        places, values = self._changes.setdefault(name, ([], []))
        places.append(seq)
        values.append(value)

    def __getitem__(self, name: str) -> Value:
        if name in self._changes:
            places, values = self._changes[name]
            index = bisect_left(places, self._present.seq)
            if index > 0:
                return values[index - 1]
        return super().__getitem__(name)

    def items(self) -> ItemsView[str, Value]:  # type: ignore[override] # the view of another dict
        """Names with the values at the present place."""
        return {name: self[name] for name in self}.items()

    def next_change(self, name: str, seq: int) -> int | None:
        """The record of the first change of a field at or after a record."""
        places, _ = self._changes.get(name, ([], []))
        index = bisect_left(places, seq)
        return places[index] if index < len(places) else None


@dataclass(eq=False)
class Instance:
    """A scenario or an action that was invoked.

    Args:
        declaration: What was invoked.
        number: Its number in the trace.
        told: The record that tells of it.
        fields: Its parameters and variables, and the global parameters.
        actor: On which it was invoked.
        present: At which expressions are evaluated.
    """

    declaration: Scenario | Action
    number: int
    told: Record
    fields: TimedFields
    actor: Actor | None
    present: Present
    labels: dict[str, list[Instance]] = field(default_factory=dict)
    node: Node | None = None  # the behavior that invokes it

    @property
    def types(self) -> tuple[str, ...]:
        """What `plan.Methods` calls its type and what that inherits, nearest first."""
        return (behavior_type(self.declaration.name), *map(behavior_type, self.declaration.bases))

    @property
    def seq(self) -> int:
        """The record that tells of it."""
        return int(self.told["seq"])

    def invoked(self, label: str) -> Instance | None:
        """What it had invoked last under a label."""
        found = [each for each in self.labels.get(label, ()) if each.seq < self.present.seq]
        return found[-1] if found else None

    @property
    def environment(self) -> Environment:
        """What names stand for in its scope."""
        return Environment(self, {"actor": self.actor} if self.actor is not None else {})


@dataclass(frozen=True, eq=False)
class EventObject:
    """What the `as` clause of an event is bound to."""

    fields: Mapping[str, Value]


class World:
    """All that a trace tells of, with its values.

    Args:
        plan: The plan.
        history: The trace.
        findings: Gets what contradicts itself.
    """

    def __init__(self, plan: Plan, history: History, findings: Findings) -> None:
        self.plan = plan
        self.present = Present()
        self.instances: dict[int, Instance] = {}
        self.objects: dict[int, Struct | Actor] = {}
        self.told: list[tuple[Struct | Actor, int]] = []  # with the record that tells of each
        self._numbers: dict[int, int] = {}
        self._history = history
        self._findings = findings
        self._of_modifiers = {name for modifier in plan.modifiers.values() for name in modifier.structure.fields}
        self._undecidable: dict[int, tuple[Expression, str | None]] = {}
        changes = {happening.mark.seq: happening for found in history.changes.values() for happening in found}
        events = (happening for found in history.events.values() for happening in found)
        events_by_seq = {happening.mark.seq: happening for happening in events}
        self.arguments: dict[int, dict[str, Value]] = {}  # of events, by record
        instances = {record["seq"]: record for record in history.instances}
        for seq, record in enumerate(history.records):
            self.present.seq = seq
            self._load(record, instances.get(seq), changes.get(seq), events_by_seq.get(seq))

    # -------------------------------------------------------- what the trace tells

    def _load(
        self, record: Record, instance: Record | None, change: Happening | None, event: Happening | None
    ) -> None:
        try:
            if instance is not None:
                self._load_instance(instance)
            elif change is not None:
                self._load_change(change)
            elif event is not None:
                told = event.told.get("exact") or {}
                arguments = {name: self.decode(value) for name, value in told.items()}
                self.arguments[event.mark.seq] = arguments
                self._compare_with_exact("arguments", event.told, arguments)
            elif record["kind"] == "behavior.start" and isinstance(record.get("arguments"), dict):
                for value in record["arguments"].values():
                    self.decode(value)  # for the objects that are told of here first
        except (Undecided, KeyError, TypeError, ValueError, AttributeError) as error:
            self._findings.violate(Rule.STRUCTURE, f"a value cannot be read: {error}", None, record["seq"])

    def _load_instance(self, record: Record) -> None:
        name, number = record["of"], record["instance"]
        declared = self.plan.scenarios.get(name) or self.plan.actions.get(name)
        if declared is None:
            self._findings.violate(
                Rule.TREE, f"`{name}` is invoked, which the scenario does not have", None, record["seq"]
            )
            return
        if number in self.instances or number in self.objects:
            self._findings.violate(Rule.STRUCTURE, f"there are two instances {number}", None, record["seq"])
        fields = TimedFields(self.present)
        actor = self.decode(record["actor"]) if "actor" in record else None
        for field_name, value in record["values"].items():
            dict.__setitem__(fields, field_name, self.decode(value))
        made = Instance(
            declared, number, record, fields, actor if isinstance(actor, Actor) else None, self.present
        )
        self.instances[number] = made
        self._numbers[id(made)] = number

    def _load_change(self, change: Happening) -> None:
        holder = self.holder(change.of)
        if holder is None and change.name in self._of_modifiers:
            return
        if holder is None:
            raise Undecided(f"nothing has the number {change.of}")
        value = self.decode(change.told["exact"])
        self._compare_with_exact("value", change.told, value)
        cast(TimedFields, holder.fields).change(change.name, change.mark.seq, value)

    def _compare_with_exact(self, name: str, record: Record, exact: Value | Mapping[str, Value]) -> None:
        """A record tells a value twice: for people, and exactly."""
        if not is_plain_form(record.get(name), exact):
            message = f"`{name}` and `exact` of a record are different values"
            self._findings.violate(Rule.STRUCTURE, message, None, self.present.seq)

    def decode(self, told: object) -> Value:
        """A value as the trace tells it.

        Raises:
            Undecided: It is of an instance that the trace does not tell of.
        """
        match told:
            case bool() | int() | float() | str():
                return told
            case list():
                return tuple(self.decode(item) for item in told)
            case {"enum": str(type_name), "member": str(member), "number": int(number)}:
                return EnumValue(type_name, member, number)
            case {"float": "nan" | "inf" | "-inf" as text}:
                return float(text)
            case {"low": int() | float() as low, "high": int() | float() as high}:
                return Range(low, high)
            case {"object": int(number), "types": list(types), "fields": dict(fields)}:
                return self._object(number, types, fields, cast(Record, told).get("actor"))
            case {"object": int(number)} if number in self.objects:
                return self.objects[number]
            case {"variable": str(name), "of": dict(of)}:
                holder = self.instances.get(of["object"]) or cast(HasFields, self.decode(of))
                return Variable(holder, name, cast(Any, None), name)
            case _:
                raise Undecided(f"nothing is known of {told!r}")

    def _object(self, number: int, types: list[str], fields: Record, actor: object) -> Struct | Actor:
        if number in self.objects or number in self.instances:
            self._findings.violate(Rule.STRUCTURE, f"there are two instances {number}", None, self.present.seq)
        known = {structure.type.name: structure.type for structure in self.plan.structures.all()}
        for index, name in enumerate(types):
            type_ = known.get(name)
            if type_ is not None and [name, *type_.bases] == types[index:]:
                break
        else:
            raise Undecided(f"there is no type {' of '.join(types[:1])!r}")
        made = (
            Actor(cast(Any, type_), str(actor), TimedFields(self.present), types[:index])
            if actor is not None
            else Struct(cast(Any, type_), TimedFields(self.present), types[:index])
        )
        self.objects[number] = made
        self.told.append((made, self.present.seq))
        self._numbers[id(made)] = number
        for name, value in fields.items():
            dict.__setitem__(made.fields, name, self.decode(value))
        return made

    def holder(self, number: int) -> Instance | Struct | Actor | None:
        """What has a number."""
        return self.instances.get(number) or self.objects.get(number)

    def next_instance(self, seq: int) -> list[int]:
        """The record of the first instance at or after a record, if there is one."""
        index = bisect_left(self._history.instances, seq, key=lambda record: int(record["seq"]))
        return [int(record["seq"]) for record in self._history.instances[index : index + 1]]

    def instances_before(self, seq: int, t: float) -> list[int]:
        """The records of instances before a record, in one instant."""
        records = self._history.instances
        last = bisect_left(records, seq, key=lambda record: int(record["seq"]))
        first = bisect_left(records, t, hi=last, key=lambda record: float(record["t"]))
        return [int(record["seq"]) for record in records[first:last]]

    def number(self, holder: object) -> int | None:
        """The number of an instance; None if the trace does not tell of it."""
        return self._numbers.get(id(holder))

    def scope_of(self, holder: HasFields, around: Environment) -> Environment:
        """What names stand for in the scope of an instance, seen from another scope."""
        if isinstance(holder, Instance):
            return holder.environment
        return replace(around, instance=holder, bindings={}, scenario=around.outermost)

    def declared(self, holder: Instance | Struct | Actor, name: str) -> FieldDeclaration | None:
        """The declaration of a field of an instance."""
        if isinstance(holder, Instance):
            return holder.declaration.structure.fields.get(name) or self.plan.globals.fields.get(name)
        structure = self.plan.structures.of(holder.type)
        latent = [member for each in structure.latents if each.type in holder.latent for member in each.members]
        fields = {member.name: member for member in latent if isinstance(member, FieldDeclaration)}
        return structure.fields.get(name) or fields.get(name)

    def samples_of(self, holder: Instance | Struct | Actor) -> tuple[Sample, ...]:
        """The variables that something samples."""
        if isinstance(holder, Instance):
            return holder.declaration.samples
        objects = self.plan.objects
        return next((objects[type_].samples for type_ in holder.types if type_ in objects), ())

    # -------------------------------------------------------- expressions

    def value(
        self, expression: Expression, environment: Environment, seq: int, reads: Reads | None = None
    ) -> Value:
        """The value of an expression as it was before a record.

        Raises:
            Undecided: It cannot be told.
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
            raise Undecided(f"the trace does not tell what `{_short(expression)}` is") from None

    def _why_undecidable(self, expression: Expression) -> str | None:
        known = self._undecidable.get(id(expression))
        if known is None:
            reason = next((why for part in walk(expression) if (why := self._why_not(part)) is not None), None)
            known = self._undecidable[id(expression)] = (expression, reason)  # kept, so that the id stays its own
        return known[1]

    def _why_not(self, part: Expression) -> str | None:
        match part:
            case Call(method=name, methods=methods):
                external = next((m for m in methods.named(name) if isinstance(m.body, External)), None)
                if external is not None:
                    return f"`{external.name}` is an external method, whose results are not in the trace"
            case Construct(type=type_, structures=structures) if not structures.of(type_).is_plain:
                return f"a value of `{type_.name}` is chosen where it is constructed"
            case _:
                pass
        return None


def walk(expression: Expression) -> Iterator[Expression]:
    """An expression with all that it consists of, the bodies of the methods that it may call included."""
    pending, seen = [expression], set()
    while pending:
        part = pending.pop()
        yield part
        pending += parts(part)
        if isinstance(part, Call) and part.method not in seen:
            seen.add(part.method)
            bodies = (method.body for method in part.methods.named(part.method))
            pending += [body for body in bodies if isinstance(body, Expression)]


def has_labels(expression: Expression) -> bool:
    """Whether an expression depends on what is invoked under labels."""
    return any(isinstance(part, Labelled) for part in walk(expression))


def _short(expression: Expression) -> str:
    return " ".join(expression.span.text.split())
