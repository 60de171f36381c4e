"""Choice of the values of instances: constraints, defaults, overrides, lists, subtypes, and the seed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from seoro.embed import load
from seoro.errors import UsageError
from seoro.lang import frontend, solve
from seoro.lang.solve import solver
from seoro.runtime.choose import choose as choosing
from seoro.runtime.instances.times import Window
from seoro.runtime.parameters.parameters import entry_parameters
from seoro.runtime.values.environment import EvaluationError, NoSolution
from seoro.runtime.values.values import Actor, HasFields, Range, Struct, Value, plain
from seoro.runtime.verdict import RunStatus
from tests.lang.helpers import lower
from tests.runtime.conftest import Prepare, RunText

HEADER = "import osc.types\n"


def chosen(folder: Path, text: str, overrides: Mapping[str, str] | None = None, seed: int = 0) -> dict[str, Value]:
    """Return the values of the parameters of the scenario `main`."""
    return entry_parameters(lower(folder, HEADER + text, overrides or {}, "main"), seed)


def in_main(folder: Path, *members: str) -> dict[str, Value]:
    """Return the values of the parameters of a scenario with given members."""
    lines = [f"    {line}" for member in members for line in member.split("\n")]
    return chosen(folder, "\n".join(["scenario main:", *lines, ""]))


def conflict(folder: Path, *members: str) -> list[str]:
    """Return the texts of the conflicting constraints."""
    with pytest.raises(NoSolution) as caught:
        in_main(folder, *members)
    return [span.text for span, _ in caught.value.places]


# ---------------------------------------------------------------- constraints and defaults (7.3.11)


@pytest.mark.parametrize(
    ("members", "expected"),
    [
        (("x: int", "keep(x == 3)"), 3),
        (("x: int with:\n    keep(it == 3)",), 3),
        (("x: int", "y: int = 7", "keep(x + y == 10)", "keep(x in [0..9])"), 3),
        (("x: float", "keep(2.0 * x == 3.0)"), 1.5),
        (("var x: int = 4", "y: int", "keep(y == x)"), 4),
        (("x: length", "y: speed = 2mps", "keep(x == y * 3s)"), 6.0),
        (("x: string", "keep(x in ['only'])"), "only"),
        (("x: range of int", "keep(x == [3..4])"), Range(3, 4)),
        (("x: range of int", "keep(x.lower() == 1 and x.upper() == 4)"), Range(1, 4)),
        (("x: int = 1", "keep(x in [5..5])"), 5),
        (("x: int = y + 1", "y: int", "keep(y == 4)"), 5),
        (("x: int = 1", "keep(default x == 2)"), 2),
        (("x: int = 1", "remove_default(x)", "keep(x > 4)", "keep(x < 6)"), 5),
        (("b: bool", "keep(b)", "x: int", "keep(b => x == 8)"), 8),
        (("b: bool = true", "x: int", "keep(x == (b ? 3 : 4))"), 3),
        (("def twice(n: int) -> int is expression 2 * n", "x: int", "keep(twice(x) == 8)"), 4),
        (("xs: list of int = [4, x]", "x: int", "keep(xs[1] == 9)"), 9),
        (("x: int", "keep(x in [1, 2, 3].filter(it > 2))"), 3),
        (("x: string", "keep(x in ['a', 'bcd'])", "keep(x.length() == 3)"), "bcd"),
    ],
)
def test_constraints_determine_values(members: tuple[str, ...], expected: Value, tmp_path: Path) -> None:
    assert in_main(tmp_path, *members)["x"] == expected


@pytest.mark.parametrize(
    ("members", "clashing"),
    [
        (("x: int", "keep(x < 3)", "keep(x == 2)", "keep(x == 5)"), [["keep(x == 2)", "keep(x == 5)"],
                                                                    ["keep(x < 3)", "keep(x == 5)"]]),
        (("x: int = 2", "keep(x > 100)"), [["2", "keep(x > 100)"]]),
        (("x: int = 2", "keep(7 == x)"), [["2", "keep(7 == x)"]]),
        (("x: int = 2", "keep(true => x == 6)"), [["2", "keep(true => x == 6)"]]),
        (("x: int = 2", "y: int = 3", "keep(x > y)"), [["2", "3", "keep(x > y)"]]),
        (("x: int", "keep(x == 1)", "keep(default x == 2)"), [["keep(x == 1)", "keep(default x == 2)"]]),
    ],
)  # fmt: skip
def test_conflicts_list_the_smallest_set(
    members: tuple[str, ...], clashing: list[list[str]], tmp_path: Path
) -> None:
    assert conflict(tmp_path, *members) in clashing


@pytest.mark.parametrize("member", ["x: int", "x: string", "x: length", "x: range of int"])
def test_an_unbounded_parameter_has_no_value(member: str, tmp_path: Path) -> None:
    with pytest.raises(NoSolution, match="has no value: give it a default, a constraint or an override"):
        in_main(tmp_path, member, "y: int", "keep(y == 1)")


def test_constraints_apply_to_members_of_a_field(tmp_path: Path) -> None:
    text = """
struct crate:
    width: int = 2
    depth: int
    keep(depth == width + 1)
struct shelf:
    top: crate
    bottom: crate with:
        keep(it.width == 5)
scenario main:
    s: shelf
    keep(s.top.width == s.bottom.depth)
"""
    assert plain(chosen(tmp_path, text)["s"]) == {
        "top": {"width": 6, "depth": 7},
        "bottom": {"width": 5, "depth": 6},
    }


def test_an_equality_makes_two_fields_hold_one_value(tmp_path: Path) -> None:
    text = """
actor cart:
    load: int
struct team:
    leader: cart
    helper: cart
scenario main:
    a: cart with:
        keep(it.load == 1)
    b: cart with:
        keep(it.load == 2)
    t: team with:
        keep(it.leader == b)
        keep(it.helper == a)
"""
    found = chosen(tmp_path, text)
    team = found["t"]
    assert isinstance(team, Struct)
    assert team.fields["leader"] is found["b"] and team.fields["helper"] is found["a"]


PARTNERS = """
actor cart:
    load: int = 1
    partner: cart
"""


def test_redundant_equalities_are_accepted(tmp_path: Path) -> None:
    text = """
struct crate:
    width: int
scenario main:
    a, b, c: crate
    keep(a == b)
    keep(b == c)
    keep(c == a)
    keep(b.width == 4)
"""
    values = chosen(tmp_path, text)
    assert values["a"] is values["b"] is values["c"]
    assert plain(values["a"]) == {"width": 4}


def test_an_instance_within_itself_is_reported(tmp_path: Path) -> None:
    crates = "struct crate:\n    on: bool\nscenario main:\n    a, b: crate\n    keep(a == (a.on ? a : b))\n"
    with pytest.raises(EvaluationError, match="`a` depends on itself"):
        chosen(tmp_path, crates)


def test_actors_may_refer_to_each_other(tmp_path: Path) -> None:
    text = (
        PARTNERS + "scenario main:\n    a: cart\n    b: cart\n    keep(a.partner == b)\n    keep(b.partner == a)\n"
    )
    text += "    keep(a.partner.load == 3)\n"
    found = chosen(tmp_path, text)
    a, b = found["a"], found["b"]
    assert isinstance(a, Actor) and isinstance(b, Actor)
    assert a.fields["partner"] is b and b.fields["partner"] is a
    assert (a.fields["load"], b.fields["load"]) == (1, 3)


def test_endlessly_nested_actors_are_reported(tmp_path: Path) -> None:
    with pytest.raises(NoSolution, match="would hold endlessly nested instances of `cart`"):
        chosen(tmp_path, PARTNERS + "scenario main:\n    a: cart\n")


def test_a_default_may_choose_between_instances(tmp_path: Path) -> None:
    text = """
actor cart:
    load: int
scenario main:
    flag: bool
    keep(flag)
    a: cart with:
        keep(it.load == 1)
    b: cart with:
        keep(it.load == 2)
    c: cart = flag ? b : a
    n: int = c.load
    all: list of cart = [a, b, c]
    keep(all[2].load == n)
"""
    found = chosen(tmp_path, text)
    assert found["c"] is found["b"] and found["n"] == 2


def test_external_methods_may_stand_in_constraints(tmp_path: Path) -> None:
    members = ("def larger(a: int, b: int) -> int is external builtins.max()",)
    path = tmp_path / "test.osc"
    path.write_text("scenario main:\n    " + "\n    ".join((*members, "x: int", "keep(x in [1, 7])",
                    "keep(larger(x, 5) == 7)", "do emit end", "")))  # fmt: skip
    scenario = load(path)
    values = entry_parameters(frontend.lower(scenario.checked), 0)
    assert values["x"] == 7


def test_the_fields_of_a_constructed_default_are_overridden_one_by_one(tmp_path: Path) -> None:
    text = """
scenario main:
    goal: position_3d = position_3d(x: 1m, y: 2m)
    keep(goal.x == 5m)
"""
    assert plain(chosen(tmp_path, text)["goal"]) == {"x": 5.0, "y": 2.0, "z": 0.0}


def test_constraints_of_a_constructed_value_hold(tmp_path: Path) -> None:
    text = """
struct crate:
    width: int
    depth: int
    keep(depth == width + 1)
scenario main:
    c: list of crate = [crate(width: 3)]
"""
    assert plain(chosen(tmp_path, text)["c"]) == [{"width": 3, "depth": 4}]


def test_global_parameters_are_chosen_with_the_scenario(tmp_path: Path) -> None:
    text = "global limit: int\nglobal margin: int = limit + 1\nscenario main:\n    x: int = margin\n"
    assert chosen(tmp_path, text + "    keep(limit == 3)\n")["x"] == 4
    assert chosen(tmp_path, "global n: int\nscenario main:\n    x: int = n\n", {"n": "7"})["x"] == 7


async def test_every_chosen_value_is_in_the_trace(run_text: RunText) -> None:
    text = "global n: int with:\n    keep(it in [4..4])\nscenario main:\n    b: bool = true\n    do emit end\n"
    start = (await run_text(text)).records[0]
    assert start["kind"] == "run.start" and start["parameters"] == {"global null::n": 4, "b": True}


# ---------------------------------------------------------------- overrides


def test_overrides_of_values_and_their_fields_replace_defaults(tmp_path: Path) -> None:
    text = """
actor cart:
    label: string = ""
scenario main:
    c: cart
    goal: position_3d = position_3d(x: 1m, y: 2m)
    twice: length = 2 * goal.x
"""
    found = chosen(tmp_path, text, {"goal.x": "3km", "c.label": '"red"', "goal": "position_3d(y: 4m)"})
    assert plain(found["goal"]) == {"x": 3000.0, "y": 4.0, "z": 0.0}
    assert found["twice"] == 6000.0
    assert isinstance(found["c"], Actor) and found["c"].fields["label"] == "red"


def test_an_override_cannot_break_a_constraint(tmp_path: Path) -> None:
    with pytest.raises(NoSolution) as caught:
        chosen(tmp_path, "scenario main:\n    x: int = 1\n    keep(x < 10)\n", {"x": "50"})
    assert [text for _, text in caught.value.places] == ["this was set from outside", "this has to hold"]


# ---------------------------------------------------------------- lists (7.3.5.2.1)


@pytest.mark.parametrize(
    ("constraints", "size"),
    [
        (("keep(it.size() == 3)",), 3),
        (("keep(it[4] == true)",), 5),
        (("keep(it[1] == true)", "keep(it.size() > 2)"), 3),
        (("keep(it.size() == n)",), 4),
        (("keep(it.size() >= 0)",), 0),
    ],
)
def test_the_length_of_a_list_follows_from_constraints(
    constraints: tuple[str, ...], size: int, tmp_path: Path
) -> None:
    block = "\n".join(f"    {line}" for line in constraints)
    found = in_main(tmp_path, "n: int = 4", f"flags: list of bool with:\n{block}")["flags"]
    assert isinstance(found, tuple) and len(found) == size


def test_the_size_of_a_list_may_depend_on_the_members_of_another(tmp_path: Path) -> None:
    members = ("a: list of int", "keep(a[0] in [2..3])", "b: list of int", "keep(b.size() == a[0])")
    values = in_main(tmp_path, *members, "keep(not b.has(it < 0 or it > 9))", "keep(a.has(it > 2))")
    assert values["a"] == (3,)
    assert len(values["b"]) == 3  # type: ignore[arg-type] # it is a list


def test_no_more_sizes_are_tried_when_constraints_clash_without_the_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[solve.Problem] = []

    def counting(problem: solve.Problem, seed: int, *, explain: bool) -> solve.Solution:
        asked.append(problem)
        return solver.solve(problem, seed, explain=explain)

    monkeypatch.setattr(solve, "solve", counting)
    members = ("n: int", "keep(n in [0..9])", "keep(n * n == n + 1)", "a: list of int", "keep(a.size() > 1)")
    assert conflict(tmp_path, *members) == ["keep(n in [0..9])", "keep(n * n == n + 1)"]
    assert len(asked) == 2  # with a size, and without one for the reason of the conflict


def test_members_of_a_list_satisfy_their_constraints(tmp_path: Path) -> None:
    text = """
struct crate:
    width: int = 1
    depth: int
    keep(depth == width + 1)
scenario main:
    row: list of crate with:
        keep(it.size() == 2)
        keep(it[1].width == 5)
"""
    row = chosen(tmp_path, text)["row"]
    assert isinstance(row, tuple)
    assert [plain(crate) for crate in row] == [{"width": 1, "depth": 2}, {"width": 5, "depth": 6}]


# ---------------------------------------------------------------- conditional subtypes (7.3.8.2)

VESSELS = """
enum cargo_kind: [people, liquid]
actor vessel:
    cargo: cargo_kind
    crew: int = 2
actor tanker inherits vessel (cargo == liquid):
    tanks: int
    keep(tanks == crew * 3)
"""


def test_a_value_has_the_fields_of_its_subtype(tmp_path: Path) -> None:
    text = VESSELS + "scenario main:\n    v: vessel with:\n        keep(it.cargo == liquid)\n    w: vessel\n"
    text += "    keep(w.cargo == people)\n    t: tanker\n    keep(t.crew == 1)\n"
    found = chosen(tmp_path, text)
    v, w, t = found["v"], found["w"], found["t"]
    assert isinstance(v, Actor) and isinstance(w, Actor) and isinstance(t, Actor)
    assert v.types[0] == "tanker" and v.fields["tanks"] == 6
    assert w.types[0] == "vessel" and "tanks" not in w.fields
    assert t.fields["tanks"] == 3


def test_constraints_may_require_the_type_of_a_value(tmp_path: Path) -> None:
    text = VESSELS + "scenario main:\n    v: vessel\n    keep(v.is(tanker))\n"
    assert plain(chosen(tmp_path, text)["v"]) == "v"
    assert all(
        chosen(tmp_path, text, seed=seed)["v"].types[0] == "tanker"  # type: ignore[union-attr]
        for seed in range(5)
    )


@pytest.mark.parametrize(
    "condition",
    [
        "v.as(tanker).tanks == 9",
        "v.cargo == liquid => v.as(tanker).tanks == 9",
        "v.as(tanker).is(tanker) and v.as(tanker).crew == 3",
    ],
)
def test_a_value_can_be_constrained_as_its_subtype(condition: str, tmp_path: Path) -> None:
    text = VESSELS + f"scenario main:\n    v: vessel\n    keep(v.cargo == liquid)\n    keep({condition})\n"
    v = chosen(tmp_path, text + "    keep(v.crew in [2..3])\n")["v"]
    assert isinstance(v, Actor) and v.fields["tanks"] == 9


def test_a_value_cannot_be_constrained_as_another_subtype(tmp_path: Path) -> None:
    text = VESSELS + "scenario main:\n    v: vessel\n    keep(v.cargo == people)\n"
    assert chosen(tmp_path, text + "    keep(v.cargo == liquid => v.as(tanker).tanks == 9)\n")
    with pytest.raises(EvaluationError, match="expected `tanker`, found `vessel`"):
        chosen(tmp_path, text + "    keep(v.as(tanker).tanks == 9)\n")


# ---------------------------------------------------------------- the seed


def test_free_choices_come_from_the_seed(tmp_path: Path) -> None:
    text = "enum rgb: [red, green, blue]\nscenario main:\n    c: rgb\n    b: bool\n    n: int in_\n"
    text = text.replace("n: int in_", "n: int with:\n        keep(it in [1..6])")
    drawn = [chosen(tmp_path, text, seed=seed) for seed in range(30)]
    assert {str(plain(found["c"])) for found in drawn} == {"rgb!red", "rgb!green", "rgb!blue"}
    assert {found["n"] for found in drawn} == {1, 2, 3, 4, 5, 6}
    assert drawn[7] == chosen(tmp_path, text, seed=7)


async def test_every_invocation_draws_new_values(run_text: RunText) -> None:
    text = """
scenario roll:
    n: int with:
        keep(it in [1..1000000])
    do log(n == 1 ? "one" : "other")
scenario main:
    do serial:
        roll()
        roll()
"""
    ran = await run_text(text)
    assert len(ran.logs) == 2


# ---------------------------------------------------------------- invocations


async def test_the_with_block_of_an_invocation_uses_both_scenarios(run_text: RunText) -> None:
    text = """
scenario tell:
    n: int = 1
    window: range of int = [0..0]
    do log(n == 8 and window.upper() == 4 ? "eight" : "other")
scenario main:
    base: int = 7
    do serial:
        tell() with:
            keep(it.n == base + 1)
            keep(it.window == [1..4])
        tell(n: [8..8], window: [2..4])
        tell()
"""
    assert [message for _, message in (await run_text(text)).logs] == ["eight", "eight", "other"]


async def test_a_conflict_in_an_invocation_ends_the_run_as_an_error(run_text: RunText) -> None:
    text = "scenario tell:\n    n: int\n    keep(n < 3)\nscenario main:\n    do tell(n: 5)\n"
    verdict = (await run_text(text)).verdict
    assert verdict.status is RunStatus.ERROR and "cannot hold" in verdict.reason


async def test_a_conflict_in_the_entry_scenario_is_reported_before_the_run(prepare_text: Prepare) -> None:
    with pytest.raises(UsageError, match="cannot hold together") as caught:
        async with prepare_text("scenario main:\n    x: int = 1\n    keep(x > 3)\n"):
            pass
    assert len(caught.value.places) == 2


async def test_the_parameters_of_an_action_are_constrained_like_others(run_text: RunText) -> None:
    text = """
import osc.helpers
scenario main:
    do log() with:
        keep(it.msg == "by constraint")
"""
    assert [message for _, message in (await run_text(text)).logs] == ["by constraint"]


async def test_an_argument_overrides_a_default_constraint_like_any_default(run_text: RunText) -> None:
    text = """
import osc.helpers
scenario tell:
    n: int
    keep(default n == 1)
    do log(n)
scenario main:
    var given: int = 3
    do serial:
        tell()
        tell(2)
        tell(n: given)
"""
    assert [message for _, message in (await run_text(text)).logs] == ["1", "2", "3"]


def test_an_expression_that_chooses_values_is_evaluated_once_per_value(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = """
struct part:
    n: int
    w: int
    keep(n in [0..9])
    keep(w in [0..3])
    keep(w != n)
scenario main:
    a, b: int
    u: part
    keep(a in [0..3])
    keep(b in [0..9])
    keep(part(n: a) == u)
    keep(u.w + b == 12)
    keep(a + b > 9)
"""
    choices = []
    choose = choosing.choose

    def counted(holder: HasFields, *arguments: Any, **named: Any) -> dict[str, Window]:
        choices.append(holder)
        return choose(holder, *arguments, **named)

    monkeypatch.setattr(choosing, "choose", counted)
    with pytest.raises(NoSolution):
        chosen(tmp_path, text)
    assert len(choices) == 1 + 4  # of `main`, and of `part(n: a)` for the values of `a`


# ---------------------------------------------------------------- numbers that are determined together


@pytest.mark.parametrize(
    ("members", "expected"),
    [
        (("a, b: int", "keep(a + b == 10)", "keep(a - b == 4)"), 7),
        (("a, b: uint", "keep(a + b == 10)", "keep(a - b == 4)"), 7),
        (("a, b: float", "keep(a + b == 10.1)", "keep(a - b == 4.3)"), 7.2),
        (("a, b, c: float", "keep(2 * a + b == 10.1 + c)", "keep(a - b / 3 == 4.3)", "keep(c - a == 0.7)"), 5.925),
        (("a, b: length", "keep(a + b == 10m)", "keep(a - 2 * b == 4m)"), 8.0),
        (("a: int", "b: float", "keep(a + b == 10.5)", "keep(a - b == 3.5)"), 7),
        (("a, b, c: int", "keep(a + b == 10 + c)", "keep(a - b == c)", "keep(c in [2..2])"), 7),
        (("a, b: int", "keep(-a - b + 3 == -7)", "keep(3 * (a - b) == 12)"), 7),
    ],
)  # fmt: skip
def test_numbers_that_constraints_determine_together_are_found(
    members: tuple[str, ...], expected: float, tmp_path: Path
) -> None:
    assert in_main(tmp_path, *members)["a"] == pytest.approx(expected, rel=1e-9)


def test_a_system_with_a_free_number_is_drawn(tmp_path: Path) -> None:
    found = in_main(tmp_path, "a, b, c: int", "keep(a + b == 10 + c)", "keep(a - b == c)", "keep(c in [1..4])")
    assert found["b"] == 5 and found["a"] == 5 + int(str(found["c"]))


@pytest.mark.parametrize(
    "members",
    [
        ("a, b: int", "keep(a + b == 10)", "keep(a - b == 5)"),
        ("a, b: float", "keep(a + b == 10)", "keep(a + b == 5)"),
        ("a, b: int", "keep(a + b == 10)", "keep(a - b == 4)", "keep(a > 8)"),
        ("a, b: uint", "keep(a + b == 10)", "keep(a - b == 14)"),
    ],
    ids=["fraction", "unlike", "third", "negative"],
)
def test_systems_without_a_solution_are_conflicts(members: tuple[str, ...], tmp_path: Path) -> None:
    assert conflict(tmp_path, *members)[: len(members) - 1] == list(members[1:])


def test_constraints_that_do_not_bound_a_number_are_shown(tmp_path: Path) -> None:
    assert conflict(tmp_path, "a, b: int", "keep(a + b == 10)") == ["a", "keep(a + b == 10)"]


# ---------------------------------------------------------------- conditional subtypes (7.3.8.2)

VEHICLES = """
enum kind: [car, truck]
struct vehicle:
    vk: kind
    wheels: int
struct truck_v inherits vehicle(vk == truck):
    keep(wheels == 6)
struct box:
    k: kind
    n: int with:
        keep(it in [1..4])
    m: int
    keep(m in [0..9])
struct big inherits box(k == truck):
    keep(n == 6)
struct small inherits box(k == car):
    keep(default m == 3)
scenario main:
"""


@pytest.mark.parametrize("decided", ["", " = truck"], ids=["constraint", "default"])
def test_constraints_of_subtypes_bound_numbers(decided: str, tmp_path: Path) -> None:
    text = VEHICLES.replace("    vk: kind\n", f"    vk: kind{decided}\n")
    member = "    v: vehicle\n" if decided else "    v: vehicle with:\n        keep(it.vk == truck)\n"
    found = chosen(tmp_path, text + member)["v"]
    assert isinstance(found, Struct) and found.fields["wheels"] == 6


def test_a_default_of_a_subtype_gives_a_value(tmp_path: Path) -> None:
    text = VEHICLES.replace("    keep(m in [0..9])\n", "")
    found = chosen(tmp_path, text + "    b: box with:\n        keep(it.k == car)\n")["b"]
    assert isinstance(found, Struct) and found.fields["m"] == 3


def test_an_impossible_subtype_is_not_chosen(tmp_path: Path) -> None:
    for seed in range(6):
        found = chosen(tmp_path, VEHICLES + "    b: box\n", seed=seed)["b"]
        assert isinstance(found, Struct) and found.latent == ["small"]
