"""`seoro test` in a process of its own, as users run it."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest

from seoro.cli.shards import Shard
from tests.executors import NAME, executor

GOOD = "import osc.types\n# pytest: smoke\nscenario good:\n    do wait elapsed(1s)\n"
BAD = """import osc.types
import osc.helpers
scenario bad:
    do serial:
        wait elapsed(2s)
    with:
        timeout(1s)
"""
FLAKY = """from pathlib import Path

def test_flaky(request):
    flag = Path(request.config.rootpath, "flag")
    assert flag.exists() or flag.touch()
"""

Seoro = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a project with two scenarios, of which one fails, and a test in Python that fails once."""
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "good.osc").write_text(GOOD)
    (tmp_path / "scenarios" / "bad.osc").write_text(BAD)
    (tmp_path / "test_once.py").write_text(FLAKY)
    (tmp_path / "seoro.toml").write_text('[test]\npaths = ["scenarios"]\n')
    return tmp_path


@pytest.fixture
def seoro_test(folder: Path) -> Seoro:
    """Return a function that runs `seoro test` in the project."""

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "seoro", "test", *arguments]
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
        return subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120
        )

    return run


def test_the_tests_of_the_project_are_run_and_failures_have_their_reasons(seoro_test: Seoro) -> None:
    done = seoro_test()
    assert done.returncode == 1
    assert "1 failed, 1 passed" in done.stdout
    assert "FAILED scenarios/bad.osc::bad" in done.stdout
    assert "run it alone: seoro exec scenarios/bad.osc" in done.stdout
    again = seoro_test("--last-failed")
    assert "1 failed" in again.stdout
    assert "passed" not in again.stdout


@pytest.mark.parametrize("arguments", [("-k", "good"), ("--tag", "smoke"), ("scenarios/good.osc", "-j", "2")])
def test_tests_are_selected(arguments: tuple[str, ...], seoro_test: Seoro) -> None:
    done = seoro_test(*arguments)
    assert (done.returncode, "1 passed" in done.stdout) == (0, True)


def test_scenarios_are_run_on_an_executor(
    seoro_test: Seoro, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    with executor(tmp_path_factory.mktemp("x")) as running:
        monkeypatch.setenv("SEORO_EXECUTOR", running.endpoint)
        done = seoro_test("--on", NAME)
    assert "1 failed, 1 passed" in done.stdout
    assert f"--on {NAME}" in done.stdout
    assert len(list((running.folder / "state" / "runs").iterdir())) == 2


def test_a_flaky_test_is_repeated_and_marked(seoro_test: Seoro, folder: Path) -> None:
    done = seoro_test("test_once.py", "--retries", "1", "--junit", "out.xml")
    assert done.returncode == 0
    assert "flaky: passed after a failed attempt" in done.stdout
    properties = Xml.parse(folder / "out.xml").findall(".//property")
    assert {"name": "flaky", "value": "true"} in [each.attrib for each in properties]


@pytest.mark.parametrize("form", ["json", "sarif", "github"])
def test_failures_are_printed_for_programs(form: str, seoro_test: Seoro) -> None:
    done = seoro_test("--output-format", form)
    assert done.returncode == 1
    assert "1 failed, 1 passed" in done.stderr
    if form == "github":
        assert done.stdout.startswith("::error file=scenarios/bad.osc,line=3,")
        return
    found = json.loads(done.stdout)
    [result] = found if form == "json" else found["runs"][0]["results"]
    message = result["message"] if form == "json" else result["message"]["text"]
    assert message.startswith("bad: ")


def test_without_tests_the_filter_is_named(seoro_test: Seoro) -> None:
    done = seoro_test("-k", "nothing")
    assert done.returncode == 2
    assert done.stderr.endswith("error: no tests found\n  = help: no test matches `-k`, `--tag` and `--shard`\n")


def test_options_of_pytest_are_passed_on(seoro_test: Seoro) -> None:
    assert "slowest durations" in seoro_test("-k", "good", "--pytest", "--durations 0 -vv").stdout


def test_shards_divide_all_tests_the_same_way_each_time() -> None:
    names = [f"a.osc::case_{number}" for number in range(500)]
    parts = [[name for name in names if Shard(number, 5).has(name)] for number in range(1, 6)]
    assert sorted(name for part in parts for name in part) == sorted(names)
    assert all(60 < len(part) < 140 for part in parts)
    assert Shard.parse("2/5").has("a.osc::case_3") is Shard(2, 5).has("a.osc::case_3")


def test_shards_are_run(seoro_test: Seoro) -> None:
    listed = [seoro_test("--list", "--shard", f"{number}/2").stdout for number in (1, 2)]
    assert sorted(line for text in listed for line in text.splitlines() if "::" in line) == [
        "scenarios/bad.osc::bad",
        "scenarios/good.osc::good",
    ]


def test_requirements_are_listed_with_the_outcomes_of_their_tests(seoro_test: Seoro, folder: Path) -> None:
    for name, requirement in (("good", "REQ-1, REQ-2"), ("bad", "REQ-2")):
        file = folder / "scenarios" / f"{name}.osc"
        file.write_text(file.read_text().replace("scenario ", f"# seoro: requirement {requirement}\nscenario "))
    (folder / "scenarios" / "test_python.py").write_text(
        'import pytest\n\n@pytest.mark.requirement("REQ-3")\ndef test_it():\n    pass\n'
    )
    (folder / "all.txt").write_text("# all\nREQ-1\nREQ-4\n")
    (folder / "seoro.toml").write_text('[test]\npaths = ["scenarios"]\nrequirements = "all.txt"\n')

    def states(*arguments: str) -> dict[str, str]:
        text = seoro_test("--requirements", *arguments).stdout.partition("TESTS\n")[2]
        lines = (line.partition("  ")[::2] for line in text.splitlines() if line.startswith("REQ"))
        return {name: rest.strip().partition("  ")[0] for name, rest in lines}

    assert states("-k", "good") == {
        "REQ-1": "passed", "REQ-2": "passed", "REQ-3": "never run", "REQ-4": "not covered"
    }  # fmt: skip
    assert states("-j", "2", "--junit", "out.xml") == {
        "REQ-1": "passed", "REQ-2": "failed", "REQ-3": "passed", "REQ-4": "not covered"
    }  # fmt: skip
    assert states("-k", "test_it")["REQ-2"] == "failed (earlier)"
    values = [
        each.get("value") for each in Xml.parse(folder / "out.xml").findall(".//property[@name='requirement']")
    ]
    assert sorted(map(str, values)) == ["REQ-1", "REQ-2", "REQ-2", "REQ-3"]
