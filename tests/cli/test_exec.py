"""`seoro exec`: output, files and exit status."""

import io
import json
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest

from seoro.cli.main import main
from seoro.cli.output import Progress

Write = Callable[[str], str]

GREETING = """import osc.types
import osc.helpers

scenario greet:
    name: string = "world"
    pause: time = 0s
    do serial:
        wait elapsed(pause)
        log("hello " + name)
"""

FAILING = """import osc.helpers

scenario broken:
    do serial:
        log("so far")
        emit fail
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)

    def write_file(text: str) -> str:
        (tmp_path / "test.osc").write_text(text)
        return "test.osc"

    return write_file


def records(path: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in Path(path).read_text().splitlines()]


def test_a_passing_scenario(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(GREETING), "--seed", "3"]) == 0
    out, err = capsys.readouterr()
    assert "seed 3" in out
    assert "hello world" in out
    assert "passed  greet" in out
    assert err == ""


def test_a_string_without_quotes_is_refused_with_them(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(GREETING), "--set", "name=Bob"]) == 2
    shown = capsys.readouterr().err
    assert "quote a string within the expression: `--set 'name=\"Bob\"'`" in shown
    typed = shlex.split(shown[shown.index("--set") : shown.index("`, in Python")])
    assert main(["exec", write(GREETING), *typed]) == 0


def test_an_error_with_a_place_is_a_diagnostic_of_the_result(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "import osc.ros\nscenario main:\n    robot: differential_drive_robot\n    do robot.init_nav2()\n"
    assert main(["exec", write(text), "--json"]) == 2
    (found,) = json.loads(capsys.readouterr().out)["diagnostics"]
    assert (found["code"], found["line"], found["column"]) == ("E0500", 4, 8)


def test_a_failing_scenario_shows_the_failed_behavior(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(FAILING)]) == 1
    out, err = capsys.readouterr()
    assert "failed  broken" in out
    assert " --> test.osc:6:9" in err
    assert "emit fail" in err


def test_the_trace_has_the_promised_records(write: Write) -> None:
    assert main(["exec", write(GREETING), "--trace", "trace.jsonl", "--seed", "7", "--clock", "virtual"]) == 0
    trace = records("trace.jsonl")
    assert [record["seq"] for record in trace] == list(range(len(trace)))
    start, end = trace[0], trace[-1]
    [own] = [each for each in start.pop("sources") if "text" in each]
    assert own["text"] == Path("test.osc").read_text()
    assert [node["source"] for node in start.pop("tree")][:1] == ["test.osc:7:8"]
    assert start | {"wall": "", "version": ""} == {
        "seq": 0,
        "t": 0.0,
        "wall": "",
        "kind": "run.start",
        "scenario": "greet",
        "file": "test.osc",
        "seed": 7,
        "parameters": {"name": "world", "pause": 0.0},
        "overrides": {},
        "clock": "virtual",
        "version": "",
        "format": "1.1",
    }
    assert end["kind"] == "run.end"
    assert (end["status"], end["reason"], end["duration"]) == ("passed", "", 0.0)
    behavior = next(record for record in trace if record["kind"] == "behavior.start" and record["type"] == "wait")
    assert behavior["source"] == "test.osc:8:9"
    stamps, text = {"seq", "t", "wall", "kind", "cause"}, {"source", "source_end", "node"}
    assert set(behavior) == stamps | text | {"id", "parent", "type", "name", "path"}
    assert all(re.fullmatch(r"\d{4}-\d\d-\d\dT[\d:.]+\+00:00", str(record["wall"])) for record in trace)


def test_coverage_is_left_in_the_folder_of_results(write: Write) -> None:
    covered = write(
        "scenario main:\n    n: int = 7\n    cover(n, range: [0..9], every: 5)\n    record(m, expression: n)\n"
    )
    assert main(["exec", covered, "-o", "out", "--seed", "3", "--clock", "virtual"]) == 0
    found = json.loads(Path("out/coverage.json").read_text())
    assert (found["scenario"], found["file"], found["seed"]) == ("main", covered, 3)
    cover, record = found["coverage"]
    assert (cover["item"], cover["kind"], cover["buckets"], cover["grade"]) == (
        "main.n",
        "cover",
        {"5..9": 1},
        0.5,
    )
    assert (record["item"], record["kind"]) == ("main.m", "record")
    sampled = [line["item"] for line in records("out/trace.jsonl") if line["kind"] in {"cover", "record"}]
    assert sampled == ["n", "m"]
    assert main(["exec", write(GREETING), "-o", "out"]) == 0
    assert not Path("out/coverage.json").exists(), "a run without items leaves none of another"


def test_the_trace_can_go_to_stdout_alone(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(GREETING), "--trace", "-"]) == 0
    out, err = capsys.readouterr()
    assert [json.loads(line)["seq"] for line in out.splitlines()] == list(range(len(out.splitlines())))
    assert "passed  greet" in err


def test_the_result_as_json(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(FAILING), "--json", "--seed", "1"]) == 1
    result = json.loads(capsys.readouterr().out)
    assert result["status"] == "failed"
    assert result["source"] == "test.osc:6:9"
    assert result["seed"] == 1


def test_the_output_folder(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(FAILING), "-o", "out/deep"]) == 1
    assert records("out/deep/trace.jsonl")[-1]["status"] == "failed"
    assert Xml.parse("out/deep/test.xml").find(".//failure") is not None
    assert "out/deep/trace.jsonl" in capsys.readouterr().out


def test_a_file_of_the_output_folder_may_be_named_too(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(GREETING)
    arguments = ["-o", "out", "--trace", "./out/trace.jsonl", "--junit", "out/test.xml"]
    assert main(["exec", file, *arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["files"] == ["out/trace.jsonl", "out/test.xml"]
    numbers = [record["seq"] for record in records("out/trace.jsonl")]
    assert numbers == list(range(len(numbers)))


def test_parameters_can_be_set(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(GREETING)
    assert main(["exec", file, "--set", 'name="robot"', "--set", "pause=1500ms", "--clock", "virtual", "-n"]) == 0
    out = capsys.readouterr().out
    assert 'name = "robot"' in out
    assert "pause = 1.5" in out


def test_parameters_are_set_by_the_file(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = (
        "import osc.helpers\n# seoro: set near=3\nscenario main:\n    near: int\n    do compare(near, '==', 3)\n"
    )
    file = write(text)
    assert main(["exec", file, "--clock", "virtual"]) == 0
    assert main(["exec", file, "--clock", "virtual"]) == 0, "the plan may be cached now"
    assert main(["exec", file, "--clock", "virtual", "--set", "near=4"]) == 1


def test_parameters_are_read_from_a_file(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(GREETING)
    Path("values.yaml").write_text('greet:\n  name: "two \\"words\\""\n  pause: 2.5\n')
    assert main(["exec", file, "--params", "values.yaml", "--set", "pause=1s", "-n", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["parameters"] == {"name": 'two "words"', "pause": 1.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("other:\n  name: a\n", "has no mapping for the scenario `greet`"),
        ("- a\n", "has no mapping"),
        ("greet: {name: 2026-01-01}\n", "expected a bool, a finite number, a text or a list"),
        ("a: [\n", "invalid YAML in the parameter file"),
        ("greet: {volume: 3}\n", "unknown parameter `volume`"),
    ],
)
def test_a_wrong_parameter_file_is_refused(
    write: Write, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    file = write(GREETING)
    Path("values.yaml").write_text(text)
    assert main(["exec", file, "--params", "values.yaml"]) == 2
    assert message in capsys.readouterr().err


def test_a_dry_run_runs_nothing(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(GREETING), "--dry-run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["parameters"] == {"name": "world", "pause": 0.0}


def test_a_dry_run_prints_values_as_the_language_writes_them(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["exec", write("import osc.types\nscenario main:\n    v: speed = 1mps\n"), "--dry-run"]) == 0
    assert "  v = 1.0mps\n" in capsys.readouterr().out


def test_a_dry_run_writes_no_files(write: Write) -> None:
    file = write(GREETING)
    assert main(["exec", file, "-n", "--trace", "trace.jsonl", "--junit", "test.xml", "-o", "out"]) == 0
    assert main(["exec", file, "-n", "--trace", "trace.jsonl", "--junit", "test.xml", "--set", "x=3"]) == 2
    assert [path.name for path in Path().iterdir()] == [file]


def test_a_scenario_is_read_from_stdin(
    write: Write, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write(GREETING)

    def run(text: bytes) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.stdin", TextIOWrapper(BytesIO(text)))
        status = main(["exec", "-", "--json", "--clock", "virtual"])
        return (status, *capsys.readouterr())

    status, out, _ = run(b'import "test.osc"\nscenario main:\n    do greet()\n')  # from the working directory
    assert (status, json.loads(out)["file"]) == (0, "<stdin>")
    status, out, err = run(b"scenario main:\n    do nothing()\n")
    assert (status, json.loads(out)["file"]) == (2, "<stdin>")
    assert " --> <stdin>:2:8" in err
    assert run(b"\xff")[2] == "error: stdin is not UTF-8 (byte 0)\n"
    assert "more than 4 MiB" in run(b"#" * 5_000_000)[2]


def test_stdin_has_either_a_scenario_or_the_parent(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", "-", "--die-with-parent"]) == 2
    assert "`--die-with-parent` needs stdin, which has the scenario" in capsys.readouterr().err


def test_a_run_needs_a_pipe_to_its_parent_to_end_with_it(write: Write) -> None:
    command = [sys.executable, "-m", "seoro", "exec", write(GREETING), "--die-with-parent"]
    ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr.startswith("error: expected a pipe as stdin")


def test_a_wall_time_limit_ends_without_a_verdict(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = "import osc.types\nscenario main:\n    do wait elapsed(1h)\n"
    assert main(["exec", write(text), "--timeout", "0.05"]) == 3
    assert "no verdict within 0.05 s of wall time" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "nonsense"], "expected PATH=VALUE"),
        (["--set", "missing=1"], "unknown parameter `missing`"),
        (["--set", "missing=1"], "`pause`; those of an invocation are written as in `log.PARAMETER`"),
        (["--scenario", "other"], "unknown scenario `other`"),
        (["--sim", "gazebo"], "unknown simulator 'gazebo'"),
        (["--world", "maze"], "`--world` needs a simulator"),
        (["--rate", "2"], "`--rate` needs a simulator"),
        (["--model-path", "models"], "`--model-path` needs a simulator"),
        (["--clock", "sim"], "the clock 'sim' needs a simulator"),
        (["--clock", "virtual", "--connect", "tcp/127.0.0.1:1"], "the clock 'virtual' is impossible with"),
        (["--seed", str(2**63)], "expected 0 to 9223372036854775807"),
        (["-o", "/proc/nowhere"], "cannot write /proc/nowhere"),
        (["--junit", "."], "cannot write .: is a folder"),
        (["--junit", "/proc/nowhere/test.xml"], "cannot write /proc/nowhere/test.xml"),
        (["--json", "--trace", "-"], "both write to stdout"),
        (["--trace", "a", "--junit", "./a"], "the trace and the result would be written to the same file, a"),
        (["-o", ".", "--trace", "test.xml"], "would be written to the same file, test.xml"),
    ],
)
def test_invalid_options_are_rejected_without_traceback(
    write: Write, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert main(["exec", write(GREETING), *arguments]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert "Traceback" not in err
    assert out == ""


def test_a_missing_simulator_is_an_error_without_a_verdict(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["exec", write(GREETING), "--connect", "tcp/127.0.0.1:1"]) == 3
    err = capsys.readouterr().err
    assert "cannot connect to tcp/127.0.0.1:1: nothing answers there" in err
    assert "= help: start a simulator there with `seoro sim mujoco`" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--dryrun"], "unknown option `--dryrun` of `seoro exec`\n  = help: did you mean `--dry-run`?\n"),
        (
            ["--clck=real"],
            "unknown option `--clck` of `seoro exec`\n  = help: did you mean `--clock` or `--local`?\n",
        ),
        (["--zzz"], "unknown option `--zzz` of `seoro exec`\n  = help: `seoro exec --help` lists the options\n"),
        (["other.osc"], "unexpected argument `other.osc`: `seoro exec` takes no more arguments"),
        (["--seed", "-1"], "argument --seed"),
        (["--rate", "0"], "expected a positive number, or max, found '0'"),
        (["--rate", "fast"], "expected a positive number, or max, found 'fast'"),
        (["--timeout", "nan"], "expected a positive number, found 'nan'"),
        (["--clock", "virtua"], "unknown value `virtua` of `--clock`"),
        (["--sim", "mujoco", "--connect", "x"], "not allowed with argument --sim"),
    ],
)
def test_a_wrong_option_is_one_clear_error(
    write: Write, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["exec", write(GREETING), *arguments])
    assert caught.value.code == 2
    out, err = capsys.readouterr()
    assert err.startswith("error: ")
    assert message in err
    assert (err.count("\n"), out) == (2, "")


def test_a_missing_file_is_one_clear_error(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    write("")
    assert main(["exec", "nope.osc"]) == 2
    assert capsys.readouterr().err == "error[E0101]: cannot read `nope.osc`: No such file or directory\n"


def test_all_errors_of_a_file_are_reported_together(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = "import osc.helpers\nscenario main:\n    do serial:\n        shout()\n        wait elapsed(3m)\n"
    assert main(["exec", write(text)]) == 2
    err = capsys.readouterr().err
    assert "test.osc:4:" in err
    assert "test.osc:5:" in err


def test_coverage_is_in_the_result_and_on_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    file = str(Path(__file__).parents[2] / "scenarios" / "coverage" / "lanes_and_speeds.osc")
    assert main(["exec", file, "--scenario", "main", "--clock", "virtual", "--json"]) == 0
    out, err = capsys.readouterr()
    found = {item["item"]: item for item in json.loads(out)["coverage"]}
    assert found["leg.target_speed"]["buckets"] == {"10..20": 1, "20..30": 2}
    assert found["leg.speed_and_side"]["grade"] == 0.25
    assert found["load.mass"]["kind"] == "record"
    assert "leg.target_speed: 2 of 4 buckets (50%)" in err
    assert "load.mass" not in err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="missing /dev/full")
@pytest.mark.parametrize("text", [GREETING, "import osc.types\nscenario main:\n    do wait elapsed(1h)\n"])
def test_a_full_disk_ends_the_run_as_an_error(write: Write, capsys: pytest.CaptureFixture[str], text: str) -> None:
    assert main(["exec", write(text), "--trace", "/dev/full"]) == 3
    assert "cannot write the trace to /dev/full: No space left on device" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["--scenario", "other"]])
def test_a_file_that_cannot_be_run_has_a_result_too(write: Write, arguments: list[str]) -> None:
    text = GREETING if arguments else GREETING.replace("log(", "shout(")
    assert main(["exec", write(text), "--junit", "out/test.xml", *arguments]) == 2
    error = Xml.parse("out/test.xml").find(".//error")
    assert error is not None
    assert error.get("type") == "invalid"
    assert "test.osc" in (error.text or "")


def test_a_closed_pipe_of_the_trace_ends_the_run_with_an_error(write: Write) -> None:
    file = write("import osc.types\nscenario main:\n    do wait elapsed(1h)\n")
    command = [sys.executable, "-m", "seoro", "exec", file, "--trace", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        error = process.stderr.read().decode()
        assert process.wait(timeout=20) == 3
    assert "cannot write the trace to stdout: its reader has closed it" in error
    assert "Exception ignored" not in error


def test_a_killed_run_leaves_the_trace_so_far(write: Write, tmp_path: Path) -> None:
    file = write(
        'import osc.helpers\nscenario main:\n    do serial:\n        log("here")\n        wait elapsed(1h)\n'
    )
    command = [sys.executable, "-m", "seoro", "exec", file, "--trace", "trace.jsonl"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        end = time.monotonic() + 20
        while '"here"' not in (Path("trace.jsonl").read_text() if Path("trace.jsonl").exists() else ""):
            assert time.monotonic() < end
            time.sleep(0.02)
        process.kill()
    assert records("trace.jsonl")[-1]["kind"] == "behavior.start"


def test_a_stopped_reader_does_not_delay_the_run(write: Write) -> None:
    lines = (
        'import osc.helpers\nscenario main:\n    do serial:\n        log("{}")\n    with:\n        repeat(300)\n'
    )
    command = [
        sys.executable,
        "-m",
        "seoro",
        "exec",
        write(lines.format("x" * 1000)),
        "--trace",
        "trace.jsonl",
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        end = time.monotonic() + 30
        while '"run.end"' not in (Path("trace.jsonl").read_text() if Path("trace.jsonl").exists() else ""):
            assert time.monotonic() < end
            time.sleep(0.02)
        assert process.poll() is None  # the rest of the output is still waiting
        out, _ = process.communicate(timeout=20)
    assert process.returncode == 0
    assert out.count(b"x" * 1000) == 300
    assert b"passed  main" in out


async def test_lines_that_are_not_taken_in_time_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.cli.output._MAX_LINES", 3)
    monkeypatch.setattr("seoro.runtime.trace.writer.PERIOD", 60.0)
    file = io.TextIOWrapper(io.BytesIO())
    progress = Progress(file)
    for number in range(10):
        progress.print_line(str(number))
    monkeypatch.setattr("seoro.cli.output._MAX_LINES", 100)
    progress.print_line("end")
    await progress.finish()
    lines = file.buffer.getvalue().decode().splitlines()
    assert lines == ["0", "1", "2", "... skipped 7 lines: the terminal was too slow", "end"]


def test_optional_modules_are_not_loaded(write: Write) -> None:
    code = "import sys; from seoro.cli.main import main; main(sys.argv[1:]); print(sorted(sys.modules))"
    command = [sys.executable, "-c", code, "exec", write(GREETING)]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "'seoro.cli.output'" in loaded
    for module in ("rich", "xml.etree", "seoro.runtime.accept", "seoro.traces", "zenoh", "pydantic"):
        assert f"'{module}'" not in loaded


def test_the_result_has_the_parameters_at_the_start(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write("import osc.helpers\nscenario main:\n    var count: int = 0\n    do increment(count)\n")
    assert main(["exec", file, "--json", "--trace", "trace.jsonl"]) == 0
    assert (
        json.loads(capsys.readouterr().out)["parameters"]
        == records("trace.jsonl")[0]["parameters"]
        == {"count": 0}
    )


def test_the_result_names_the_missing_event(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(
        "import osc.types\nscenario main:\n    event go\n    do serial(duration: 1s):\n        wait @go\n"
    )
    assert main(["exec", file, "--json", "--clock", "virtual", "--junit", "test.xml"]) == 1
    out, err = capsys.readouterr()
    [activity] = json.loads(out)["explanation"]["activities"]
    assert (activity["kind"], activity["event"], activity["source"]) == ("waits", "go", "test.osc:5:9")
    text = "waiting since 0.000 s: `wait @go` (test.osc:5:9)"
    assert text in err
    assert text in (Xml.parse("test.xml").findtext(".//failure") or "")


def test_a_reader_that_has_stopped_cannot_keep_the_run_from_being_interrupted(write: Write) -> None:
    text = (
        'import osc.helpers\nscenario main:\n    do serial:\n        log("{}")\n    with:\n        repeat(300)\n'
    )
    command = [sys.executable, "-m", "seoro", "exec", write(text.format("x" * 1000)), "--trace", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        process.stderr.readline()  # it runs
        time.sleep(0.3)  # until it is over, and waits for the reader
        process.send_signal(signal.SIGINT)
        process.stderr.readline()
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 130
        assert b"Fatal" not in process.stderr.read()


def test_an_invalid_file_has_a_result_as_json(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(GREETING.replace("log(", "shout(")), "--json"]) == 2
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert (result["status"], result["reason"]) == ("invalid", "unknown scenario or action `shout`")
    assert result["diagnostics"][0]["line"] == 9
    assert "shout" in err


def test_a_fault_is_reported_with_its_place_in_python(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = write("import osc.helpers\nimport osc.faulty\nscenario main:\n    do explode()\n")
    Path("seoro.libraries").mkdir()
    Path("seoro.libraries/faulty.osc").write_text("action explode\n")
    Path("seoro.libraries/faulty.py").write_text(
        "from seoro import ActionContext, action\n"
        '@action("explode")\nasync def explode(ctx: ActionContext) -> None:\n    raise KeyError("bug")\n'
    )
    assert main(["exec", file, "--junit", "test.xml"]) == 3
    err = capsys.readouterr().err
    assert "error: `explode` raised KeyError: 'bug'\n --> test.osc:4:8" in err
    assert "faulty.py:4, `explode`; `--debug` shows the traceback" in err
    assert "Traceback" not in err
    assert "Traceback" in (Xml.parse("test.xml").findtext(".//error") or "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="missing /dev/full")
def test_a_result_that_cannot_be_written_hides_no_verdict(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["exec", write(FAILING), "--junit", "/dev/full"]) == 3
    out, err = capsys.readouterr()
    assert "error  broken" in out
    assert "cannot write /dev/full: No space left on device; the run itself: failed, `emit fail`" in err
