"""Choice of the values of an instance and its objects (7.3.6, 7.3.11), with the solver.

Rules are collected, overridden defaults are dropped, and lists get their sizes. The rest is one problem for the
solver: a cell for each free scalar, a term for each constraint. If a value turns out to be of a conditional
subtype, the members of the subtype are added, and the rest is chosen again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import cast

from seoro.errors import CONFLICT
from seoro.lang import solve
from seoro.lang.plan import Constraint, ConstraintMember, Expression, Latent, Structure
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import holds
from seoro.runtime.choose.forms import NotYet, all_of
from seoro.runtime.choose.gather import INVOCATION, OVERRIDE, Gathering
from seoro.runtime.choose.refusals import Rules, no_bounds, no_solution
from seoro.runtime.choose.slots import Computation, Rule, Slot, assign, domain_of, mentions
from seoro.runtime.choose.symbolic import Translation
from seoro.runtime.choose.widening import Widening
from seoro.runtime.instances.applied import Attached
from seoro.runtime.instances.times import Times, Window
from seoro.runtime.values.environment import Environment, Evaluate, EvaluationError, NoSolution
from seoro.runtime.values.values import Actor, Fields, HasFields, Range, Struct, Value, make_room

MAX_SIZE = 1000  # of a list with a chosen size
SIZES_TRIED = 64  # smallest first; beyond that, any size is accepted


def choose(
    holder: HasFields,
    roots: tuple[Structure, ...],
    given: Mapping[str, Value],
    environment: Environment,
    evaluate: Evaluate,
    *,
    constraints: tuple[ConstraintMember, ...] = (),
    around: Environment | None = None,
    overrides: tuple[Constraint, ...] = (),
    value: Slot | None = None,
    attached: tuple[Attached, ...] = (),
    times: Times | None = None,
) -> dict[str, Window]:
    """Choose the values of an instance, and set its fields.

    Args:
        holder: The instance; its fields are `Fields`, and get the values.
        roots: Its structures; for the entry scenario, the global parameters first.
        given: Given values.
        environment: Its environment.
        evaluate: Evaluates expressions.
        constraints: Constraints of its invocation.
        around: Environment of those, with the instance as `it`; by default, its own.
        overrides: Constraints by the user.
        value: Slot of the instance, if it is a struct or an actor.
        attached: Its modifiers.
        times: Its timing parameters; None if it has none.

    Returns:
        Windows of its constrained times.

    Raises:
        NoSolution: No values meet all constraints, or a number or a string is unbounded.
        EvaluationError: An expression has no value.
    """
    gathering = Gathering(environment.plan)
    if value is not None:
        gathering.add_value(value, roots[0], given)
    else:
        for structure in roots:
            gathering.add_root(structure, holder, given, environment)
    around = around or environment
    if times is not None:
        gathering.add_times(times, holder, environment)
        gathering.add_constraints(tuple(times.constraints()), around.bind(it=holder), INVOCATION)
    gathering.add_constraints(constraints, around, INVOCATION)
    for other in attached:
        gathering.add_root(other.structure, other.environment.instance, other.given, other.environment, INVOCATION)
        gathering.add_constraints(other.constraints, other.around, INVOCATION)
    gathering.add_constraints(overrides, environment, OVERRIDE)
    gathering.expand()
    make_room(len(gathering.slots.all))
    return _Choice(gathering, holder, environment.seed.value, evaluate, times).run()


class _Choice:
    """One choice, from the collected rules to the values."""

    def __init__(
        self, gathering: Gathering, holder: HasFields, seed: int, evaluate: Evaluate, times: Times | None
    ) -> None:
        self._gathering = gathering
        self._slots = gathering.slots
        self._evaluate = evaluate
        self._seed = seed
        self._holder, self._times = holder, times
        self._translation = Translation(self._slots, evaluate, self._put)
        self._pins: list[solve.Constraint] = []
        self._computation = Computation(gathering.slots, evaluate)
        self._names: dict[str, int] = {}

    def run(self) -> dict[str, Window]:
        """Choose until no value is of a further subtype."""
        while True:
            self._size_lists()
            self._prepare()
            rules = dict(self._constraints())
            try:
                values = self._solve(rules, self._pins).values
            except NoSolution as reason:
                found = self._certain(rules) if isinstance(reason.__cause__, solve.Unbounded) else []
                if not found:
                    raise
            else:
                self._put(values)
                undecided = self._undecided()
                found = [
                    (slot, latent)
                    for slot, latent in undecided
                    if slot.instance.fields[latent.field] == latent.value
                ]
                if not found:
                    break
            self._add_latents(found)
        windows = self._widen(rules, values) if self._times is not None else {}
        self._finish()
        return windows | self._defined_windows()

    def _add_latents(self, found: list[tuple[Slot, Latent]]) -> None:
        """Add the members of conditional subtypes, and keep the values in these subtypes."""
        for slot, latent in found:
            decider = self._slots.of(slot.made)[latent.field]
            if decider.cell is not None:
                term = terms.Compare("==", terms.CellRef(decider.cell), terms.Const(latent.value))
                self._pins.append(solve.Constraint(term, latent.span, latent.span.text))
            self._gathering.add_latent(slot, latent)
        self._gathering.expand()

    def _certain(self, rules: Rules) -> list[tuple[Slot, Latent]]:
        """Return the subtypes that values certainly have, nearest to the base first."""
        problem = self._problem(rules, self._pins)
        found: list[tuple[Slot, Latent]] = []
        for slot, latent in self._undecided():
            deciding = self._deciding(slot.instance, latent)
            if deciding is not None and all(_is_certain(problem, condition) for condition in deciding):
                found.append((slot, latent))
        return found

    def _undecided(self) -> Iterator[tuple[Slot, Latent]]:
        """Yield the subtypes whose members values of their bases do not have yet."""
        for slot, latent in self._gathering.latents:
            if latent.type not in slot.instance.types and latent.base in slot.instance.types:
                yield slot, latent

    def _deciding(self, made: Struct | Actor, latent: Latent) -> tuple[terms.Term, ...] | None:
        """Return the conditions of a subtype; None if one needs a field of another subtype."""
        try:
            return self._translation.deciding(made, latent.type)
        except NotYet:
            return None

    def _conditional(self) -> Iterator[tuple[solve.Constraint, Rule | None]]:
        """Yield the constraints of possible subtypes, as far as the values have the fields."""
        for slot, latent in self._gathering.latents:
            made = slot.instance
            if latent.type in made.types:
                continue
            deciding = self._deciding(made, latent)
            if deciding is None:
                continue
            for rule in self._gathering.rules_of(slot, latent):
                with suppress(NotYet, EvaluationError):
                    term = terms.Implies(all_of(list(deciding)), self._translated(rule))
                    yield solve.Constraint(term, rule.span, rule.span.text), rule

    def _widen(self, rules: Rules, values: Mapping[solve.Cell, solve.Value]) -> dict[str, Window]:
        """Widen the windows of times as far as possible."""
        assert self._times is not None
        written = {each: rule is not None for each, rule in rules.items()} | dict.fromkeys(self._pins, False)
        widening = Widening(written, values)
        windows = widening.widen(self._times, self._slots.of(self._holder))
        self._put(widening.values)
        return windows

    def _defined_windows(self) -> dict[str, Window]:
        """Return the windows of times that are defined by equalities."""
        found: dict[str, Window] = {}
        for name in self._times.names if self._times is not None else ():
            definition = self._slots.of(self._holder)[name].definition
            bounds = self._holder.fields[name]
            if definition is not None and isinstance(bounds, Range):
                found[name] = Window(bounds, definition.span, definition.span.text)
        return found

    # ------------------------------------------------------------ cells and constraints

    def _prepare(self) -> None:
        """Drop overridden rules, and give every scalar a cell."""
        self._gathering.settle_defaults()
        for slot in self._slots.all:
            if isinstance(slot.holder.fields, Fields):
                slot.holder.fields.compute = self._computation.of(slot.holder)
            domain = domain_of(slot.type)
            if domain is not None and slot.limits is not None:
                domain = solve.Real(*slot.limits)
            if slot.cell is None and not slot.is_given and slot.definition is None and domain is not None:
                self._slots.stand_for(slot, solve.Cell(self._unique(slot.path), slot.span, domain))

    def _unique(self, path: str) -> str:
        """Return a unique name for a cell; a field and a global parameter may have the same path."""
        count = self._names[path] = self._names.get(path, 0) + 1
        return path if count == 1 else f"{path} ({count})"

    def _problem(self, rules: Rules, more: list[solve.Constraint]) -> solve.Problem:
        cells = [cell for slot in self._slots.all for cell in (slot.cell, slot.size) if cell is not None]
        return solve.Problem(tuple(cells), (*rules, *more))

    def _solve(self, rules: Rules, more: list[solve.Constraint], *, explain: bool = True) -> solve.Solution:
        problem = self._problem(rules, more)
        try:
            return solve.solve(problem, self._seed, explain=explain)
        except solve.Conflict as conflict:
            raise no_solution(conflict, rules) from conflict
        except solve.Unbounded as unbounded:
            raise no_bounds(unbounded, rules) from unbounded
        except (solve.NeedsSolver, solve.Undecided) as undecided:
            places = tuple((cell.span, "") for cell in undecided.cells)
            raise NoSolution(str(undecided), "E0443", places) from undecided

    def _constraints(self) -> Iterator[tuple[solve.Constraint, Rule | None]]:
        """Yield all constraints with their rules."""
        for rule in self._gathering.rules:
            term = self._term(rule)
            if term is not None and term != terms.Const(True):
                strength = solve.Strength.DEFAULT if rule.is_default else solve.Strength.HARD
                yield solve.Constraint(term, rule.span, rule.span.text, strength), rule
        yield from self._conditional()
        for slot in self._slots.all:
            if "lower" in slot.parts:
                low, high = (slot.parts[key].cell for key in ("lower", "upper"))
                assert low is not None and high is not None
                term = terms.Compare("<=", terms.CellRef(low), terms.CellRef(high))
                yield solve.Constraint(term, slot.span, f"{slot.path}.lower() <= {slot.path}.upper()"), None

    def _term(self, rule: Rule) -> terms.Term | None:
        """Return the term of a rule; None if it is settled, or about a missing field."""
        if rule.is_void or rule.is_done or (rule.subject is not None and rule.subject.definition is rule):
            return None
        try:
            return self._translated(rule)
        except NotYet:
            return None

    def _translated(self, rule: Rule) -> terms.Term:
        if rule.condition is not None:
            return self._translation.condition(rule.condition, rule.environment)
        assert rule.subject is not None and rule.value is not None
        return self._translation.equality(rule.subject, rule.value, rule.environment)

    def _is_postponed(self, rule: Rule) -> bool:
        """Whether a rule is about a field of a subtype that a value does not have."""
        if rule.condition is None or rule.is_void or rule.is_done:
            return False
        try:
            self._translated(rule)
        except NotYet:
            return True
        return False

    # ------------------------------------------------------------ lists

    def _size_lists(self) -> None:
        """Give each list the smallest size that its constraints allow (7.3.5.2.1)."""
        while True:
            unsized = [slot for slot in self._slots.all if slot.is_unsized]
            if not unsized:
                return
            least, mentioned = mentions(self._gathering.rules, self._slots)
            for slot in unsized:
                low = least.get(id(slot), 0)
                domain = solve.Integer(low, MAX_SIZE)
                self._slots.stand_for(slot, solve.Cell(f"{slot.path}.size()", slot.span, domain))
            for slot in unsized:
                if id(slot) in mentioned:
                    self._gathering.expand()
                    self._prepare()
                    size = self._smallest(slot)
                else:
                    size = least.get(id(slot), 0)
                slot.size, slot.is_sized = None, True
                self._gathering.size_list(slot, size)
            self._gathering.expand()

    def _smallest(self, slot: Slot) -> int:
        """Return the smallest permitted size; after `SIZES_TRIED` sizes, any permitted one."""
        size = slot.size
        assert size is not None
        rules = dict(self._constraints())
        low = int(solve.lowest(self._problem(rules, self._pins), size))
        any_size: solve.Value | None = None
        for candidate in range(low, min(low + SIZES_TRIED, MAX_SIZE)):
            term = terms.Compare("==", terms.CellRef(size), terms.Const(candidate))
            pin = solve.Constraint(term, slot.span, f"{slot.path}.size() == {candidate}")
            try:
                self._solve(rules, [*self._pins, pin], explain=False)
            except NoSolution as reason:
                if not isinstance(reason.__cause__, solve.Conflict):
                    raise
            else:
                return candidate
            if any_size is None:
                any_size = self._solve(rules, self._pins).values[size]  # else no other size helps
        return cast(int, any_size)

    # ------------------------------------------------------------ values

    def _put(self, chosen: Mapping[solve.Cell, solve.Value]) -> None:
        """Put the values of cells into the instances."""
        for slot in self._slots.all:
            if slot.cell is not None and slot.cell in chosen:
                assign(slot, cast(Value, chosen[slot.cell]))

    def _finish(self) -> None:
        """Compute values without cells, check postponed constraints, and leave plain fields."""
        self._computation.is_final = True
        for slot in self._slots.all:
            slot.holder.fields[slot.key]
        for rule in self._gathering.rules:
            if self._is_postponed(rule) and not self._evaluate(cast(Expression, rule.condition), rule.environment):
                raise NoSolution("this constraint cannot hold", CONFLICT, ((rule.span, ""),))
        holders = {id(slot.holder): slot.holder for slot in self._slots.all}
        for holder in holders.values():
            fields = holder.fields
            if isinstance(fields, Fields):
                fields.compute = None
                in_order = {name: fields[name] for name in (*self._slots.of(holder), *fields)}
                fields.clear()
                fields.update(in_order)


def _is_certain(problem: solve.Problem, condition: terms.Term) -> bool:
    """Whether a condition holds for all values."""
    if not terms.cells_of(condition):
        return holds(condition, {})
    return solve.follows(problem, condition)
