"""Completions at the cursor in incomplete texts."""

from pathlib import Path

import pytest

from seoro.lsp.items import FIRST
from seoro.lsp.signatures import signature_at
from tests.lsp.helpers import SCENARIO, analysis, completions, split

IN = " " * 12


@pytest.mark.parametrize(
    ("marked", "offered", "not_offered"),
    [
        pytest.param("sc|", {"scenario", "import"}, {"wait"}, id="declarations"),
        pytest.param("import osc.|", {"osc.ros", "osc.types"}, {"scenario"}, id="modules"),
        pytest.param("struct s:\n    a: |", {"box", "speed", "color", "int"}, {"wait", "main"}, id="types"),
        pytest.param("struct s:\n    a: list of |", {"box", "speed"}, {"wait"}, id="types of elements"),
        pytest.param("struct s:\n    def f(a: |", {"box"}, {"limit"}, id="types of parameters"),
        pytest.param("struct s:\n    def f() -> |", {"box"}, {"limit"}, id="types of results"),
        pytest.param("struct s:\n    a: color = |", {"red", "green"}, {"wait"}, id="members that are expected"),
        pytest.param("struct s:\n    a: color = color!|", {"red", "green"}, {"box"}, id="members"),
        pytest.param("struct s:\n    |", {"event", "def", "keep"}, {"wait", "scenario"}, id="members of types"),
        pytest.param("struct s inherits |", {"box"}, {"crane", "main"}, id="structs to inherit"),
        pytest.param("scenario s inherits |", {"main", "crane"}, {"box"}, id="scenarios to inherit"),
        pytest.param("extend crane.|", {"lift"}, {"reach"}, id="actions to extend"),
        pytest.param("unit u of |", {"speed", "mass"}, {"box"}, id="physical types"),
        pytest.param(f"{IN}|", {"serial", "wait", "crane", "robot"}, {"event", "limit"}, id="behaviors"),
        pytest.param(f"{IN}x: |", {"serial", "wait", "crane"}, {"speed"}, id="behaviors behind a label"),
        pytest.param(f"{IN}crane.|", {"lift"}, {"times", "reach"}, id="actions of an actor"),
        pytest.param(f"{IN}robot.|", {"nav_to_pose", "init_nav2"}, {"lift"}, id="actions of libraries"),
        pytest.param(f"{IN}crane.lift(|", {"what", "height", "crate"}, {"wait"}, id="arguments"),
        pytest.param(f"{IN}crane.lift(what: crate, |", {"height"}, {"what"}, id="arguments that are left"),
        pytest.param(f"{IN}crane.lift(crate, |", {"height"}, {"what"}, id="arguments behind positional ones"),
        pytest.param(f"{IN}crane.lift(what: box(|", {"weight", "paint"}, {"height"}, id="inner arguments"),
        pytest.param(f"{IN}crane.lift(\n{IN}    |", {"what", "height"}, {"wait"}, id="arguments on lines"),
        pytest.param(f"{IN}emit |", {"go", "end", "fail"}, {"start", "limit"}, id="events to emit"),
        pytest.param(f"{IN}emit go(|", {"count"}, set(), id="parameters of events"),
        pytest.param(f"{IN}wait |", {"@", "elapsed", "limit"}, {"serial"}, id="event specifications"),
        pytest.param(f"{IN}wait @|", {"go", "first", "end"}, {"limit"}, id="events and labels"),
        pytest.param(f"{IN}wait @first.|", {"start", "end", "fail"}, {"go"}, id="events of a label"),
        pytest.param(f"{IN}wait @go as e if e.|", {"count"}, {"limit"}, id="parameters of an occurrence"),
        pytest.param(f"{IN}wait @go if crate.|", {"weight", "times"}, {"lift"}, id="members of a struct"),
        pytest.param(f"{IN}wait @go if crate.times(|", {"count", "of"}, set(), id="parameters of methods"),
        pytest.param(f"{IN}wait @go if crate.paint == |", {"red", "green"}, set(), id="the other side's members"),
        pytest.param(f"{IN}crane.lift(crate) with:\n{IN}    |", {"until", "keep", "repeat"}, {"wait"}, id="with"),
        pytest.param("    keep(crate.|", {"weight"}, {"lift"}, id="constraints"),
        pytest.param("    def f(a: box) -> mass is expression a.|", set(), {"lift"}, id="methods that are new"),
    ],
)
def test_fitting_names_are_offered(tmp_path: Path, marked: str, offered: set[str], not_offered: set[str]) -> None:
    found = completions(tmp_path, marked).keys()
    assert offered - found == set()
    assert not_offered & found == set()


@pytest.mark.parametrize(
    "marked",
    ["# sc|", f"{IN}wait @go # |", f"{IN}crane.lift('a|", f'{IN}crane.lift("""a\n|', "scenario |", "struct a|"],
)
def test_comments_strings_and_new_names_have_no_completions(tmp_path: Path, marked: str) -> None:
    assert not {"scenario", "wait", "limit", "box"} & completions(tmp_path, marked).keys()


def test_units_of_the_expected_type_come_first(tmp_path: Path) -> None:
    found = completions(tmp_path, f"{IN}crane.lift(crate, height: 3|")
    assert found["mm"].rank == FIRST < found["kg"].rank
    assert "length" in found["mm"].detail
    found = completions(tmp_path, f"{IN}wait elapsed(3m|")
    assert found["min"].rank == FIRST < found["mm"].rank


def test_values_of_the_expected_type_come_first(tmp_path: Path) -> None:
    found = completions(tmp_path, f"{IN}crane.lift(what: |")
    assert found["crate"].rank == FIRST < found["limit"].rank
    assert found["box"].rank == FIRST < found["pose_3d"].rank


def test_arguments_show_their_types_and_defaults(tmp_path: Path) -> None:
    item = completions(tmp_path, f"{IN}crane.lift(|")["height"]
    assert (item.detail, item.insert) == ("length = 1m", "height: ")


def test_members_of_an_element_are_offered_within_list_operators(tmp_path: Path) -> None:
    before = SCENARIO.replace("    crate: box\n", "    crate: box\n    boxes: list of box\n")
    found = completions(tmp_path, f"{IN}wait @go if boxes.filter(it.|", before)
    assert {"weight", "paint"} <= found.keys()


def test_an_open_bracket_above_does_not_hide_the_statement(tmp_path: Path) -> None:
    found = completions(tmp_path, f"{IN}crane.lift(what: box(\n{IN}wait elapsed(1s)\n{IN}crane.|")
    assert "lift" in found


def test_the_last_valid_state_completes_broken_declarations(tmp_path: Path) -> None:
    good = analysis(tmp_path, SCENARIO)
    broken = SCENARIO.replace("scenario main:", "scenario main")
    bad = analysis(tmp_path, broken.replace("    robot:", "    ) robot:"))
    from seoro.lsp.completion import complete

    text, offset = split(broken + f"{IN}crane.|")
    assert "lift" in {item.label for item in complete(text, offset, [bad, good]).items}


def test_names_of_other_namespaces_get_their_prefix(tmp_path: Path) -> None:
    before = "import osc.standard.types\n\nnamespace mine\n\nstruct own\n"
    found = completions(tmp_path, "struct s:\n    a: |", before)
    assert {"own", "stdtypes::speed"} <= found.keys()
    assert "speed" not in found


def test_the_signature_of_a_call_is_shown(tmp_path: Path) -> None:
    text, offset = split(SCENARIO + f"{IN}crane.lift(crate, |")
    found = signature_at(text, offset, [analysis(tmp_path, SCENARIO)])
    assert found is not None
    assert found.label == "crane.lift(what: box, height: length = 1m)"
    assert found.documentation == "Lifts."
    assert found.parameters is not None
    assert (found.parameters[1].label, found.active_parameter) == ("height: length = 1m", 1)
    text, offset = split(SCENARIO + f"{IN}crane.lift(height: 1m, what: |")
    named = signature_at(text, offset, [analysis(tmp_path, SCENARIO)])
    assert named is not None and named.active_parameter == 0


@pytest.mark.parametrize("step", [7, pytest.param(1, marks=pytest.mark.more)])
def test_every_prefix_of_a_text_has_completions(tmp_path: Path, step: int) -> None:
    from seoro.lsp.completion import complete

    analyses = [analysis(tmp_path, SCENARIO)]
    for offset in range(0, len(SCENARIO) + 1, step):
        assert complete(SCENARIO, offset, analyses).start <= offset
        signature = signature_at(SCENARIO, offset, analyses)
        assert signature is None or signature.label
