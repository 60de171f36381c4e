"""The command itself."""

import os
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest

import seoro
from seoro.cli.commands import GROUPS
from seoro.cli.main import main
from seoro.errors import BackendError, UsageError
from seoro.security.keys import VARIABLE


def test_help_lists_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["--help"])
    assert caught.value.code == 0
    out = capsys.readouterr().out
    for title, commands in GROUPS.items():
        assert f"\n{title}:\n" in out
        for command in commands:
            assert f"\n  {command} " in out


def test_without_a_command_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "run scenarios:" in capsys.readouterr().err


def test_the_command_is_also_a_module() -> None:
    command = [sys.executable, "-m", "seoro", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == f"seoro {seoro.__version__}\n"


@pytest.mark.parametrize("command", ["exec", "check", "fmt", "explain", "sim"])
def test_each_command_has_examples(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    assert f"  seoro {command} " in capsys.readouterr().out


@pytest.mark.parametrize("before", [None, "other.keys"])
def test_a_command_leaves_the_environment_of_its_caller_as_it_was(
    before: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    if before is not None:
        monkeypatch.setenv(VARIABLE, before)
    assert main(["ps", "--executor", "tls/127.0.0.1:1", "--keys", str(tmp_path / "none")]) == 2
    assert os.environ.get(VARIABLE) == before


def test_the_public_names_exist() -> None:
    for name in seoro.__all__:
        assert getattr(seoro, name).__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        seoro.nonsense  # type: ignore[attr-defined]  # noqa: B018 - the access is the test


def test_importing_seoro_is_light() -> None:
    """A node that imports a wire schema must not pull in the parser, nor a program that embeds seoro Zenoh."""
    heavy = "{'lark', 'zenoh', 'pydantic', 'anyio', 'numpy', 'rich'}"
    code = f"import sys, seoro; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("arguments", "message", "hint"),
    [
        (["exce", "x.osc"], "unknown command `exce`", "did you mean `exec`?"),
        (["sweep", "x.osc"], "`seoro sweep` was replaced", "use `seoro campaign run`"),
        (["ros", "topc"], "unknown command `seoro ros topc`", "did you mean `topic`?"),
        (["exec", "x.osc", "--clock", "vitual"], "unknown value `vitual` of `--clock`", "did you mean `virtual`?"),
        (["keys", "xyz"], "unknown command `seoro keys xyz`", "expected init, add, renew"),
        (["xyzzy"], "unknown command `xyzzy`", "`seoro --help` lists the commands"),
        (["stop", "--all"], "unsupported option `--all`", "`seoro estop` stops all robots"),
        (["stop"], "expected either runs or `--mine`", "`seoro ps`"),
        (["router", "--listen", "tcp/127.0.0.1:99999"], "invalid port value", "another endpoint with `--listen`"),
        (["router", "--listen", "tcp/"], "is an invalid endpoint", "another endpoint with `--listen`"),
    ],
)
def test_an_invalid_command_line_is_rejected_with_a_hint(
    arguments: list[str], message: str, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(arguments)
    except SystemExit as ended:
        status = int(str(ended.code))
    err = capsys.readouterr().err
    assert status == 2
    assert message in err
    assert hint in err


def test_words_of_other_tools_are_understood(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.osc").write_text("import osc.helpers\nscenario main:\n    do log('hello')\n")
    assert main(["run", str(tmp_path / "x.osc")]) == 0
    assert "hello" in capsys.readouterr().out
    for arguments in (["help"], ["help", "exec"]):
        with pytest.raises(SystemExit, match="0"):
            main(arguments)
    assert "usage: seoro exec" in capsys.readouterr().out


def test_a_closed_pipe_is_not_an_error(tmp_path: Path) -> None:
    file = tmp_path / "talk.osc"
    lines = "\n".join(f'        log("line {number}")' for number in range(3000))
    file.write_text(f"import osc.helpers\nscenario main:\n    do serial:\n{lines}\n")
    command = f"{sys.executable} -m seoro exec {file} | head -1"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.startswith(str(file))


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (BrokenPipeError(), 3, ""),
        (BackendError("unexpected reply \x1b[2J"), 3, "error: unexpected reply \ufffd[2J\n"),
        (UsageError("missing file"), 2, "error: missing file\n"),
        (KeyError("x"), 3, "error: internal error: KeyError: 'x'; `--debug` shows the traceback\n"),
    ],
)
def test_errors_in_task_groups_are_reported_like_others(
    error: Exception, status: int, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(_options: object) -> int:
        raise ExceptionGroup("in tasks", [ExceptionGroup("within", [error])])

    printed = StringIO()
    monkeypatch.setattr(printed, "close", lambda: None)
    monkeypatch.setattr(sys, "stderr", printed)
    monkeypatch.setattr("seoro.cli.check_command.run", run)
    assert main(["check", "hello.osc"]) == status
    assert printed.getvalue() == message


def test_an_option_before_the_command_is_rejected_with_its_place(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--debug", "exec", "x.osc"])
    assert capsys.readouterr().err == (
        "error: unknown option `--debug` of `seoro exec`\n  = help: write it after `seoro exec`\n"
    )
