"""Commands obey the settings of a project."""

import json
from pathlib import Path

import pytest

from seoro.cli.main import main

GREET = """import osc.types
action greet:
    name: string
"""
GREET_PY = """from seoro import ActionContext, action

@action("greet")
async def greet(ctx: ActionContext, name: str) -> None:
    ctx.log(f"hello {name}")
"""
HELLO = 'import osc.shop\nscenario hello:\n    do greet("Anna")\n'


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a project with a library and a scenario that uses it."""
    for folder in ("libs", "scenarios"):
        (tmp_path / folder).mkdir()
    (tmp_path / "libs" / "shop.osc").write_text(GREET)
    (tmp_path / "libs" / "shop.py").write_text(GREET_PY)
    (tmp_path / "scenarios" / "hello.osc").write_text(HELLO)
    (tmp_path / "seoro.toml").write_text('libraries = ["libs"]\noutput = "out"\ntimeout = 60\n')
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SEORO_EXECUTOR", raising=False)
    return tmp_path


def test_a_run_uses_libraries_and_the_output_folder_of_its_project(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "scenarios"]) == 0
    assert main(["exec", "scenarios/hello.osc", "--clock", "virtual"]) == 0
    assert "hello Anna" in capsys.readouterr().out
    assert (project / "out" / "hello" / "test.xml").exists()


def test_options_come_before_directives_and_these_before_settings(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "seoro.toml").write_text(
        'libraries = ["libs"]\nsimulator = "mujoco"\nworld = "maze"\nendpoint = "tcp/127.0.0.1:9"\ntimeout = 60\n'
    )
    file = project / "scenarios" / "hello.osc"

    def settings() -> dict[str, tuple[object, str]]:
        assert main(["config", str(file), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)["settings"]
        return {key: (row["value"], row["from"]) for key, row in found.items()}

    found = settings()
    assert found["simulator"] == ("mujoco", "seoro.toml")
    assert found["world"] == ("maze", "seoro.toml")
    assert found["rate"] == (1.0, "default")
    file.write_text(f"# seoro: world empty\n# seoro: timeout 9\n\n{HELLO}")
    found = settings()
    assert found["world"] == ("empty", "the scenario file")
    assert found["timeout"] == (9.0, "the scenario file")
    assert main(["exec", str(file), "--clock", "virtual", "-n"]) == 0
    assert "replaces its world" in capsys.readouterr().err


def test_the_environment_comes_before_the_settings(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "seoro.toml").write_text('endpoint = "tcp/127.0.0.1:9"\n')
    assert main(["ps"]) == 2
    assert "tcp/127.0.0.1:9" in capsys.readouterr().err
    monkeypatch.setenv("SEORO_EXECUTOR", "tcp/127.0.0.1:11")
    assert main(["ps"]) == 2
    assert "tcp/127.0.0.1:11" in capsys.readouterr().err
    assert main(["config"]) == 0
    assert "SEORO_EXECUTOR" in capsys.readouterr().out


def test_a_project_may_name_the_executor_of_its_runs(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "seoro.toml").write_text('libraries = ["libs"]\nexecutor = "lab-a"\nendpoint = "tcp/127.0.0.1:9"\n')
    command = ["exec", "scenarios/hello.osc", "--clock", "virtual"]
    assert main(command) == 2
    assert "tcp/127.0.0.1:9" in capsys.readouterr().err
    assert main([*command, "--local"]) == 0


def test_a_project_leaves_warnings_out(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "scenarios" / "hello.osc").write_text(HELLO.replace("    do", "    event never_used\n    do"))
    assert main(["check", "scenarios"]) == 0
    assert "E0703" in capsys.readouterr().err
    (project / "seoro.toml").write_text('libraries = ["libs"]\nignore = ["E0703"]\n')
    assert main(["check", "scenarios"]) == 0
    assert capsys.readouterr().err == ""


def test_an_invalid_setting_is_refused_with_its_place(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "seoro.toml").write_text('simulatr = "mujoco"\n')
    assert main(["exec", "scenarios/hello.osc"]) == 2
    err = capsys.readouterr().err
    assert "seoro.toml:1: unknown setting `simulatr`\n  = help: did you mean `simulator`?" in err


def test_pytest_obeys_the_project(project: Path, pytester: pytest.Pytester) -> None:
    (project / "seoro.toml").write_text('libraries = ["libs"]\nsimulator = "none such"\n')
    result = pytester.runpytest_subprocess(str(project / "scenarios"))
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*none such*"])
    (project / "seoro.toml").write_text('libraries = ["libs"]\n')
    pytester.runpytest_subprocess(str(project / "scenarios")).assert_outcomes(passed=1)
