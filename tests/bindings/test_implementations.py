"""Actions and modifiers in Python, matched with what a library declares."""

import pytest

from tests.bindings.conftest import GARDEN, MAIN, Check, CheckGarden

GOOD = """
@action("gardener.water")
async def water(ctx: ActionContext, gardener: Actor, plant: str, litres: float) -> None: ...

@modifier("patiently")
async def patiently(ctx: ModifierContext, child: Child, duration: float) -> Outcome:
    return Outcome(Status.FAILED, "it took too long")
"""


def test_matching_functions_give_no_diagnostics(check_garden: CheckGarden) -> None:
    assert check_garden(GOOD) == []


@pytest.mark.parametrize(
    ("good", "wrong", "code", "message"),
    [
        (
            "litres: float) -> None",
            "liters: float) -> None",
            "E0604",
            "it takes (plant, liters), the declaration has (plant, litres)",
        ),
        ("plant: str, litres", "plant: str, *, litres", "", ""),
        ("plant: str, litres", "plant: str, /, litres", "E0604", "it takes (plant, litres), the"),
        (", plant: str, litres: float", "", "E0604", "it takes (), the declaration has (plant, litres)"),
        (
            "litres: float) -> None",
            "litres: float, **rest: object) -> None",
            "E0604",
            "it takes (plant, litres, **rest)",
        ),
        (
            "litres: float) -> None",
            "litres: int) -> None",
            "E0604",
            "the type of `litres` does not match the declaration: expected `float`, found `int`",
        ),
        ("litres: float) -> None", "litres) -> None", "E0604", "`litres` has no annotation"),
        ("plant: str", "plant: 'Unheard'", "E0604", "cannot evaluate its annotations: NameError"),
        ("plant: str", "plant: object", "", ""),
        ("litres: float", "litres: float | None", "", ""),
        ("async def water", "def water", "E0610", '`@action("gardener.water", thread=True)`'),
        ('@action("gardener.water")', '@action("gardener.water", thread=True)', "E0611", "but is `async`"),
        (
            '@action("gardener.water")\nasync def',
            '@action("gardener.water", thread=True)\ndef',
            "",
            "",
        ),
        ("async def patiently", "def patiently", "E0604", "it is not an `async` function"),
        ("gardener.water", "gardener.watr", "E0603", "did you mean `gardener.water`?"),
        ("gardener.water", "tools.sharpen", "E0603", "remove `@action`"),
        ("'patiently'", "'patently'", "", ""),
        ('"patiently"', '"patently"', "E0603", "did you mean `patiently`?"),
        ("child: Child, ", "", "E0604", "`garden.patiently` does not match the modifier `patiently`"),
        ("duration: float", "duration: str", "E0604", "child: Child, duration: float)`"),
        ("-> Outcome", "-> bool", "E0604", "it returns `bool`, not `Outcome`"),
    ],
)
def test_mismatches_are_reported(
    good: str, wrong: str, code: str, message: str, check_garden: CheckGarden
) -> None:
    found = check_garden(GOOD.replace(good, wrong))
    assert [each for each, _ in found] == ([code] if code else [])
    assert all(message in text for _, text in found)


def test_a_mismatch_is_reported_at_the_declaration_with_the_expected_signature(check_files: Check) -> None:
    files = {
        "main.osc": MAIN,
        "seoro.libraries/garden.osc": GARDEN,
        "seoro.libraries/garden.py": "from seoro import *\n" + GOOD.replace(", plant: str", ""),
    }
    [found] = check_files(files).checked.diagnostics
    assert found.primary.span.text == "gardener.water"
    assert found.primary.span.file.name.endswith("seoro.libraries/garden.osc")
    expected = "async def water(ctx: ActionContext, actor: Actor, plant: str, litres: float)"
    assert found.help == f"expected `{expected}`"


def test_modifiers_get_the_arguments_of_their_own_function(check_files: Check) -> None:
    """`note` is an action and a modifier; each gets the arguments of its own function."""
    files = {
        "main.osc": """import osc.notes
scenario main:
    var n: int = 0
    do serial:
        note("once") with:
            note(3)
            counted(n)
        note(3)
""",
        "seoro.libraries/notes.osc": """action note:
    text: string
modifier note:
    text: string
modifier counted:
    how_often: string
""",
        "seoro.libraries/notes.py": """from seoro import *
@action("note")
async def note(ctx: ActionContext, text: str) -> None: ...
@modifier("note")
async def noted(ctx: ModifierContext, child: Child, text: object) -> Outcome: ...
@modifier("counted")
async def counted(ctx: ModifierContext, child: Child, how_often: Variable[float]) -> Outcome: ...
""",
    }
    [found] = check_files(files).checked.diagnostics
    assert (found.code, found.primary.span.line) == ("E0301", 8)


def test_a_module_that_raises_is_one_message_with_the_line(check_garden: CheckGarden) -> None:
    [(code, text)] = check_garden("def f():\n    raise KeyError('a')\nf()")
    assert code == "E0601"
    assert "cannot import the Python module `garden` of `osc.garden`: KeyError: 'a' (garden.py, line 4)" in text


@pytest.mark.parametrize(
    ("python", "message"),
    [
        ("def f(:", "SyntaxError: invalid syntax (garden.py, line 3)"),
        ("import sys; sys.exit('enough')", "SystemExit: enough (garden.py, line 3)"),
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("import garden", "use a relative import: `from .garden import ...`"),
    ],
)
def test_a_module_that_cannot_be_imported_is_one_message(
    python: str, message: str, check_garden: CheckGarden
) -> None:
    [(code, text)] = check_garden(python)
    assert code == "E0601"
    assert message in text


def test_declared_actions_need_a_module(check_garden: CheckGarden) -> None:
    [(code, text)] = check_garden(None)
    assert code == "E0602"
    assert "`osc.garden` declares `gardener.water`, but has no Python module" in text
    assert "seoro.libraries/garden.py" in text


def test_two_functions_for_one_action_are_refused(check_garden: CheckGarden) -> None:
    [(code, text)] = check_garden(GOOD + GOOD.partition("@modifier")[0].replace("def water", "def water_too"))
    assert code == "E0605"
    assert "both `garden.water` and `garden.water_too` implement the action `gardener.water`" in text


def test_an_action_with_a_do_has_no_function(check_files: Check) -> None:
    files = {
        "main.osc": "import osc.garden\n",
        "seoro.libraries/garden.osc": "action rest:\n    do serial:\n        emit end\n",
        "seoro.libraries/garden.py": "from seoro import *\n@action('rest')\nasync def f(ctx: ActionContext): ...",
    }
    [found] = check_files(files).checked.diagnostics
    assert found.message.endswith("the declaration has a `do`, and so needs no function")


def test_errors_of_the_scenario_do_not_hide_mismatches_of_a_library(check_files: Check) -> None:
    files = {
        "main.osc": MAIN + "\nstruct a:\n    x: nothing\n",
        "seoro.libraries/garden.osc": GARDEN,
        "seoro.libraries/garden.py": "from seoro import *\n" + GOOD.replace("plant: str", "plant: int"),
    }
    assert sorted(found.code for found in check_files(files).checked.errors) == ["E0211", "E0604"]
