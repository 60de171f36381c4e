"""`compare_traces.py` notices differences, and nothing else, with checkouts that write what a file names."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.tools.compare_traces import compare
from tests.tools.trace_files import first_difference
from tests.tools.trace_runs import Run, conformance_runs, project_runs
from tests.tools.workers import WorkerFailed

LIMIT = 60.0  # [s] of wall time that no run here comes near

# `does.json` has what a checkout does, by names of scenarios.
FAKE = """
import json, os, sys, threading
from pathlib import Path

def main(arguments):
    name = arguments[1]
    does = json.loads(Path(__file__).with_name("does.json").read_text()).get(name, {})
    if "dies" in does:
        os._exit(does["dies"])
    if "hangs" in does:
        threading.Event().wait()
    out = Path(arguments[arguments.index("-o") + 1])
    out.mkdir()
    wall = f"2026-01-01T00:00:00.{os.getpid()}+00:00"
    kinds = does.get("kinds", ["run.start", "log", "run.end"])
    records = [{"seq": n, "wall": wall, "kind": kind} for n, kind in enumerate(kinds)]
    (out / "trace.jsonl").write_text("".join(json.dumps(record) + "\\n" for record in records))
    print(f"{name}: passed in 1.00 s of its clock, {os.getpid() / 100:.2f} s real")
    print(does.get("says", ""), file=sys.stderr)
    if "raises" in does:
        raise RuntimeError(does["raises"])
    return does.get("status", 0)
"""


def checkout(folder: Path, **does: dict[str, Any]) -> Path:
    """Make a checkout that does things by the names of scenarios."""
    package = folder / "seoro" / "cli"
    package.mkdir(parents=True)
    for each in (package.parent, package):
        (each / "__init__.py").touch()
    (package / "main.py").write_text(FAKE)
    (package / "does.json").write_text(json.dumps(does))
    return folder


def different(checkouts: tuple[Path, Path], *names: str, limit: float = LIMIT) -> list[str]:
    runs = [Run(name, ("exec", name)) for name in names]
    compared = compare(checkouts, runs, limit)
    assert [each.run for each in compared] == runs
    return [each.run.name for each in compared if each.differences]


@pytest.fixture
def there(tmp_path: Path) -> Path:
    return checkout(tmp_path / "there")


def test_stamps_and_places_may_differ(there: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    here = checkout(tmp_path / "here", one={"says": f"error in {tmp_path}/here/lib.osc"})
    there = checkout(tmp_path / "other", one={"says": f"error in {tmp_path}/other/lib.osc"})
    assert different((there, here), "one", "two") == []
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("does", "shown"),
    [
        ({"kinds": ["run.start", "event", "run.end"]}, ["trace.jsonl:2:", '"kind": "log"', '"kind": "event"']),
        ({"kinds": ["run.start", "log"]}, ["trace.jsonl:3:", '"kind": "run.end"', "(nothing)"]),
        ({"status": 1}, ["exit status: there 0, here 1"]),
        ({"says": "warning"}, ["stderr:1:", "here  warning"]),
        ({"raises": "oh"}, ["exit status: there 0, here 70", "stderr:2:", "Traceback"]),
        ({"dies": 7}, ["exit status: there 0, here the process ended with 7"]),
    ],
)
def test_a_difference_is_shown(
    there: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], does: dict[str, Any], shown: list[str]
) -> None:
    here = checkout(tmp_path / "here", two=does)
    assert different((there, here), "one", "two", "three") == ["two"]
    output = capsys.readouterr().out
    assert output.startswith("DIFFERENT two\n")
    assert "three" not in output
    for each in shown:
        assert each in output


def test_a_run_has_a_limit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    there = checkout(tmp_path / "there", one={"dies": 7})
    here = checkout(tmp_path / "here", one={"hangs": True})
    assert different((there, here), "one", limit=0.01) == ["one"]
    assert "here no end within 0.01 s" in capsys.readouterr().out


def test_a_checkout_needs_a_package(there: Path, tmp_path: Path) -> None:
    with pytest.raises(WorkerFailed, match="expected it in"):
        different((there, tmp_path), "one")


def test_a_checkout_may_lie_beside_one_with_a_longer_name(tmp_path: Path) -> None:
    says = "error in {}/lib.osc"
    there = checkout(tmp_path / "a", one={"says": says.format(tmp_path / "a")})
    here = checkout(tmp_path / "ab", one={"says": says.format(tmp_path / "ab")})
    assert different((there, here), "one") == []


@pytest.mark.parametrize(
    ("one", "other", "is_same"),
    [
        (
            '{"wall": "2026-01-01T00:00:00.1+00:00", "x": 1}',
            '{"wall": "2027-01-01T00:00:00.2+00:00", "x": 1}',
            True,
        ),
        (
            '{"wall": "2026-01-01T00:00:00.1+00:00", "x": 1}',
            '{"wall": "2026-01-01T00:00:00.1+00:00", "x": 2}',
            False,
        ),
        ('{"kind": "run.start", "version": "1"}', '{"kind": "run.start", "version": "2"}', True),
        ('{"kind": "event", "version": "1"}', '{"kind": "event", "version": "2"}', False),
        ('{"type": "wait", "clean_up": 0.0}', '{"type": "wait", "clean_up": 0.1}', True),
        ("passed  a in 1.00 s of its clock, 0.1 s real", "passed  a in 1.00 s of its clock, 0.2 s real", True),
        ("passed  a in 1.00 s of its clock, 0.1 s real", "passed  a in 2.00 s of its clock, 0.1 s real", False),
        ('{"a": 1, "b": 2}', '{"b": 2, "a": 1}', False),
    ],
)
def test_lines_differ_by_lasting_fields_only(tmp_path: Path, one: str, other: str, is_same: bool) -> None:
    (tmp_path / "one").write_text(one)
    (tmp_path / "other").write_text(other)
    assert (first_difference(tmp_path / "one", tmp_path / "other", {}) is None) == is_same


def test_scenarios_of_the_project_are_run_in_their_simulators() -> None:
    names = [run.name for run in project_runs(["mujoco"])]
    assert "scenarios/coverage/lanes_and_speeds.osc" in names
    assert "scenarios/navigation/obstacle.osc [mujoco]" in names
    assert not any("mujoco" in run.name for run in project_runs([]))
    assert not any("wait_for_a_topic" in name for name in names)


def test_cases_are_run_as_their_headers_say(tmp_path: Path) -> None:
    (tmp_path / "run.py").write_text(
        "from types import SimpleNamespace as Case\n"
        "def find_cases(root): return sorted(root.glob('*.osc'))\n"
        "def load_case(path): return Case(is_check=path.name == 'a.osc', args=('--set', 'x=1'))\n"
    )
    for name in ("a.osc", "b.osc"):
        (tmp_path / name).touch()
    check, run = conformance_runs(tmp_path)
    assert check.arguments == ("check", "--format", "json", str(tmp_path / "a.osc"))
    assert run.arguments[-4:] == ("--seed", "0", "--set", "x=1")
