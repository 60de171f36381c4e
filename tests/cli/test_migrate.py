"""`seoro migrate`: rewritings, decisions, output and exit status."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from seoro.cli.main import main

HEAD = """import osc.helpers
import osc.moveit2

struct pause:
    left: int = 3

scenario main:
"""
MODIFIER = """    do serial:
        log('a')
        # twice
        repeat(2)  # of them
        one: log('b') with:
            timeout(3s)
"""
MOVED = """    do serial:
        log('a')
        # twice
        one: log('b') with:
            timeout(3s)
    with:
        repeat(2)  # of them
"""
SEVERAL = """    do serial:
        retry(3)
        log('a')
        timeout(3s)
        repeat(2)"""
SEVERAL_MOVED = """    do serial:
        log('a')
    with:
        retry(3)
        timeout(3s)
        repeat(2)"""
VALUES = """    x: pause = pause
    do serial:
        wait elapsed(pause.left)
        wait elapsed(x.left + 1)
"""
VALUES_MENDED = """    x: pause = pause()
    do serial:
        wait elapsed(pause().left * 1s)
        wait elapsed((x.left + 1) * 1s)
"""
IN_A_BLOCK = """    do serial:
        log('a')
        parallel:
            repeat(2)
            log('b')
        with:
            # soon
            timeout(3s)
"""
MOVED_INTO_THE_BLOCK = """    do serial:
        log('a')
        parallel:
            log('b')
        with:
            # soon
            repeat(2)
            timeout(3s)
"""
ACTOR = """    # the left one
    tool: arm = arm(arm_joints: ['a',
        'b'], base_link: 'link0')  # of Franka
    do serial:
        log(tool.base_link)
"""
CONSTRAINED = """    # the left one
    tool: arm with:
        keep(it.arm_joints == ['a',
        'b'])
        keep(it.base_link == 'link0')  # of Franka
    do serial:
        log(tool.base_link)
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path / "a.osc"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        pytest.param(MODIFIER, MOVED, id="modifier"),
        pytest.param(MODIFIER.rstrip(), MOVED.rstrip(), id="without a last line break"),
        pytest.param(MODIFIER.replace("\n", "\r\n"), MOVED.replace("\n", "\r\n"), id="CRLF"),
        pytest.param(
            "    do serial:\n        log('a')\n        repeat(2)",
            "    do serial:\n        log('a')\n    with:\n        repeat(2)",
            id="last member",
        ),
        pytest.param(
            "    do serial:\n        serial:\n            repeat(2)\n            log('a')\n        log('b')\n",
            "    do serial:\n        serial:\n            log('a')\n        with:\n            repeat(2)\n"
            "        log('b')\n",
            id="nested",
        ),
        pytest.param(
            "    do serial:\n        repeat(2)\n        serial:\n            log('a')\n"
            "            # in\n    # out\n",
            "    do serial:\n        serial:\n            log('a')\n    with:\n        repeat(2)\n"
            "            # in\n    # out\n",
            id="comments at the end",
        ),
        pytest.param(SEVERAL, SEVERAL_MOVED, id="several"),
        pytest.param(IN_A_BLOCK, MOVED_INTO_THE_BLOCK, id="block"),
        pytest.param(ACTOR, CONSTRAINED, id="constructor"),
        pytest.param(
            "    tool: robot = arm('one')\n    do log('a')\n",
            "    tool: arm with:\n        keep(it.namespace == 'one')\n    do log('a')\n",
            id="positional",
        ),
        pytest.param(VALUES, VALUES_MENDED, id="values"),
        pytest.param("    tool: arm = arm()\n    do log('a')\n", "    tool: arm\n    do log('a')\n", id="empty"),
    ],
)
def test_files_are_rewritten_once(before: str, after: str, file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_bytes(f"{HEAD}{before}".encode())
    assert main(["migrate", "--write", "a.osc"]) == 0
    assert file.read_bytes().decode() == f"{HEAD}{after}"
    assert main(["check", "a.osc"]) == 0
    capsys.readouterr()
    assert main(["migrate", "--write", "a.osc"]) == 0
    assert capsys.readouterr().out == ""
    assert file.read_bytes().decode() == f"{HEAD}{after}"


@pytest.mark.parametrize(
    ("text", "decision"),
    [
        ("    do serial:\n        repeat(2)\n", "a.osc:9:9: needs a decision: `repeat` is a modifier"),
        ("    x: arm = arm('a',  # why\n        ['b'])\n    do log('a')\n", "unknown method or struct `arm`"),
        ("    do logg('a')\n", "[E0"),
    ],
)
def test_what_needs_a_decision_is_listed_and_kept(
    text: str, decision: str, file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(HEAD + text)
    assert main(["migrate", "--write", "a.osc"]) == 2
    assert decision in capsys.readouterr().out
    assert file.read_text() == HEAD + text


def test_without_write_changes_are_only_listed(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(HEAD + MODIFIER)
    assert main(["migrate", "--diff", "."]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("a.osc:11: moved `repeat` into the `with:` block of the composition\n--- a.osc\n")
    assert "\n+    with:\n+        repeat(2)  # of them\n" in out
    assert err == "1 file to rewrite (with --write), 1 without open decisions, 0 with\n"
    assert file.read_text() == HEAD + MODIFIER


def test_json_has_rewritings_and_decisions(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = f"import osc.docker\n{HEAD}{MODIFIER}        docker_exec('a', 'ls')\n"
    file.write_text(text)
    assert main(["migrate", "--json", "--write", "a.osc"]) == 2
    result = json.loads(capsys.readouterr().out)
    [found] = result["files"]
    assert result["written"]
    assert found["file"] == "a.osc"
    assert found["changed"]
    assert found["rewritings"] == [
        {"line": 12, "title": "moved `repeat` into the `with:` block of the composition"}
    ]
    [decision] = found["decisions"]
    assert (decision["code"], decision["line"]) == ("E0612", 14)
    assert "docker exec" in decision["help"]


NOTED = """import osc.helpers
scenario main:
    event ready
    event over
    x: int = 3
    y: int = -x
    do parallel:
        serial:
            wait @ready
            wait elapsed(1s)
            wait @over if x > 2
        serial:
            emit ready
            emit over
            emit end
            log('late')
"""


def test_notes_name_statements_that_mean_something_else(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(NOTED)
    assert main(["migrate", "a.osc"]) == 0
    assert [line.partition(";")[0] for line in capsys.readouterr().out.splitlines()] == [
        "a.osc:6:14: note: `-x` is negative",
        "a.osc:11:13: note: `wait @over if x > 2` waits for the next `over`",
        "a.osc:16:13: note: unreachable after `emit end`",
    ]
    assert main(["migrate", "--json", "a.osc"]) == 0
    [found] = json.loads(capsys.readouterr().out)["files"]
    assert [(note["line"], note["column"]) for note in found["notes"]] == [(6, 14), (11, 13), (16, 13)]


@pytest.mark.parametrize(
    ("option", "hint"),
    [
        ("--scenario-parameter-file=p.yaml", "write `--params FILE`"),
        ("-s", "behaviors wake at events"),
        ("--dot", "write `--report`"),
    ],
)
def test_options_of_scenario_execution_are_translated(
    option: str, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["exec", "a.osc", option])
    assert ended.value.code == 2
    assert hint in capsys.readouterr().err
