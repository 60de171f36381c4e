"""Directives in the comments of scenario files: values, merging, and errors with their places."""

from dataclasses import replace
from pathlib import Path

import pytest

from seoro.embed.directives import _READERS, Axis, Directives, FileDirectives, read_directives
from seoro.errors import UsageError
from seoro.lang.source import SourceFile
from seoro.pytest_plugin.collector import read_marks

SCENARIO = "scenario main:\n    do wait elapsed(1s)\n"


def read(text: str, *lines: int, path: Path | None = None) -> FileDirectives:
    """Read the directives of a text with scenarios in some lines."""
    return read_directives(SourceFile("test.osc", text, path), frozenset(lines))


def test_comments_of_a_scenario_and_of_the_file() -> None:
    text = f"# Two.\n# seoro: timeout 3s\n# pytest: skip\n\nimport osc.types\n# seoro: seed 1, 2\n{SCENARIO}"
    found = read(text, 7)
    assert found.common.timeout == 3.0
    assert [mark.text for mark in found.common.marks] == ["skip"]
    assert found.scenarios == {7: replace(found.common, seeds=(1, 2))}


def test_directives_of_a_scenario_take_precedence_over_the_file() -> None:
    text = f"# seoro: expect failed: late\n# seoro: seed 1\n\n# seoro: expect error\n# seoro: seed 2\n{SCENARIO}"
    found = read(text, 6)
    assert (found.common.expect, found.common.reason, found.common.seeds) == ("failed", "late", (1,))
    assert (found.scenarios[6].expect, found.scenarios[6].reason, found.scenarios[6].seeds) == ("error", "", (2,))


def test_other_comments_may_stand_between() -> None:
    found = read(f"import osc.types\n# seoro: seed 4\n# It is slow.\n#\n{SCENARIO}", 5)
    assert found.scenarios[5].seeds == (4,)


def test_values_may_hold_commas_brackets_and_quotes() -> None:
    text = """# seoro: parametrize a.b=[f(1, 2), [1, 2], "],", ']', "\\""] c=[true]\n""" + SCENARIO
    assert read(text, 2).scenarios[2].axes == (
        Axis("a.b", ("f(1, 2)", "[1, 2]", '"],"', "']'", '"\\""')),
        Axis("c", ("true",)),
    )


def test_marks_have_arguments() -> None:
    comments = read("# pytest: skip(reason='x'), skipif(True, reason=\"y\")\n" + SCENARIO, 2).scenarios[2].marks
    assert read_marks(comments) == (pytest.mark.skip(reason="x"), pytest.mark.skipif(True, reason="y"))


def test_parameter_files_lie_beside_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "values").mkdir()
    for name in ("b", "a"):
        (tmp_path / "values" / f"{name}.yaml").write_text("")
    (tmp_path / "c.yaml").write_text("")
    found = read("# seoro: params values/*.yaml, c.yaml\n" + SCENARIO, 2, path=tmp_path / "test.osc")
    assert [file.name for file in found.scenarios[2].files] == ["a.yaml", "b.yaml", "c.yaml"]


def test_directives_select_simulators_and_a_world(tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text("")
    text = f"# seoro: simulators mujoco, pybullet\n# seoro: world hall.yaml\n{SCENARIO}"
    found = read(text, 3, path=tmp_path / "test.osc").scenarios[3]
    assert (found.simulators, found.world) == (("mujoco", "pybullet"), str(tmp_path / "hall.yaml"))
    assert read(f"# seoro: world maze\n{SCENARIO}", 2).scenarios[2].world == "maze"


@pytest.mark.parametrize("again", ["set a=2", "parametrize a=[2]"])
def test_a_parameter_has_one_value(again: str) -> None:
    with pytest.raises(UsageError, match="duplicate parameter `a`"):
        read(f"# seoro: set a=1\n# seoro: {again}\n{SCENARIO}", 3)


def test_values_of_parameters_end_with_the_line() -> None:
    text = f'# seoro: set speed=2mps\n\n# seoro: set goal.name="a = b"\n# seoro: set go[1].x=1m\n{SCENARIO}'
    given = (("speed", "2mps"), ("goal.name", '"a = b"'), ("go[1].x", "1m"))
    assert read(text, 5).scenarios[5].overrides == given


@pytest.mark.parametrize(
    ("comment", "message"),
    [
        ("seoro: set speed", "invalid `set speed`: expected PATH=VALUE"),
        ("seoro: set =2", "expected PATH=VALUE"),
        ("seoro: set a b=2", "expected PATH=VALUE"),
        ("seoro: parametrise x=[1]", "unknown directive `parametrise`"),
        ("seoro: expect success", "unknown status `success`"),
        ("seoro: parametrize speed", "invalid values of parameters"),
        ("seoro: parametrize speed=[1mps", "invalid values of parameters"),
        ("seoro: parametrize speed=[1mps,,2mps]", "invalid values of parameters"),
        ("seoro: parametrize", "missing parameter"),
        ("seoro: parametrize a=[1] a=[2]", "duplicate parameter `a`"),
        (f"seoro: parametrize a=[{','.join('1' * 1001)}]", "more than 1000"),
        ("seoro: params none.yaml", "parameter file not found: `none.yaml`"),
        ("seoro: params /etc/hosts", "parameter file not found: `/etc/hosts`"),
        ("seoro: seed one", "expected whole numbers from 0"),
        ("seoro: timeout never", "invalid timeout `never`: expected seconds"),
        ("seoro: simulators moon", "unknown simulator `moon`"),
        ("seoro: simulators", "unknown simulator ``"),
        ("seoro: world", "missing world"),
        ("seoro: world none.yaml", "world file not found: `none.yaml`"),
        ("seoro: test it", "unexpected `it` after `test`"),
        ("pytest: unknown_mark", "not found in `markers`"),
        ("pytest: os.system('true')", "invalid marks"),
        ("pytest: _private", "Marker name must NOT start with underscore"),
        ("pytest: smoke(open('x'))", "invalid marks"),
        ("pytest: 3", "invalid marks"),
        ("pytest:", "missing mark"),
        ("pytest: parametrize('a', [1])", "unsupported mark `parametrize`"),
    ],
)
def test_invalid_directives_are_rejected(tmp_path: Path, comment: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_marks(read(f"# {comment}\n{SCENARIO}", 2, path=tmp_path / "test.osc").scenarios[2].marks)
    assert message in str(caught.value)
    assert str(caught.value.span) == "test.osc:1:1"


@pytest.mark.parametrize("text", [f"{SCENARIO}    # seoro: seed 3\n", "import osc.types\n# seoro: seed 3\n\n"])
def test_misplaced_directives_are_rejected(text: str) -> None:
    with pytest.raises(UsageError, match="misplaced directive"):
        read(text, 1)


@pytest.mark.parametrize("text", ["# see oro: seed 3", "# The seoro: seed 3", "x # seoro: seed 3"])
def test_other_comments_are_comments(text: str) -> None:
    assert read(f"{text}\n{SCENARIO}", 2) == FileDirectives(Directives(), {})


def test_every_comment_is_documented() -> None:
    document = (Path(__file__).parents[2] / "docs" / "how-to" / "pytest.md").read_text()
    assert [word for word in _READERS if f"| `# seoro: {word}" not in document] == []
