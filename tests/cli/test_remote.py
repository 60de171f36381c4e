"""Executors on the command line: `seoro serve`, `exec --on`, `ps`, `attach`, `logs`, `stop`, `get` and `rm`."""

import io
import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.runtime.execution.outputs import INDEX
from tests.executors import HELLO, LONG, NAME, RunningExecutor, executor
from tests.sim_nodes.engines import needs_pictures

FAILING = """import osc.helpers
scenario broken:
    event go
    do parallel:
        wait @go
        serial:
            log("so far")
            wait elapsed(1s)
            emit fail
"""
WORKSHOP = Path(__file__).parents[2] / "examples/workshop"
DRIVE = """import osc.driving
scenario main:
    robot: differential_drive_robot
    do robot.drive(linear: 0.3mps, duration: 1s)
"""
PYTHON = """from seoro import ActionContext, action

@action("write_output")
async def write_output(ctx: ActionContext, text: str) -> None:
    ctx.write_output("left.txt", text.encode(), "what was left")

@action("break_down")
async def break_down(ctx: ActionContext) -> None:
    print("about to break")
    raise ValueError("broken")
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x"), "--jobs", "2", "--allow", "python") as running:
        yield running


@pytest.fixture(autouse=True)
def _here(lab: RunningExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEORO_EXECUTOR", lab.endpoint)


def write(text: str, name: str = "test.osc") -> str:
    path = Path(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return name


def same(text: str) -> str:
    """Replace the times, which differ from run to run."""
    return re.sub(r"[\d.]+ s real", "? s real", text)


@pytest.mark.parametrize("text", [HELLO, FAILING])
def test_a_remote_run_prints_and_exits_like_a_local_run(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["exec", write(text), "--seed", "3", "--clock", "virtual", "-o", "out"]
    here = main(arguments), capsys.readouterr()
    files = {path.name for path in Path("out").iterdir()}
    for path in Path("out").iterdir():
        path.unlink()
    there = main([*arguments, "--on", NAME]), capsys.readouterr()
    assert there[0] == here[0]
    assert same(there[1].out) == same(here[1].out)
    assert same(there[1].err) == same(here[1].err)
    assert {path.name for path in Path("out").iterdir()} == files


@pytest.mark.engine("mujoco")
def test_a_simulated_run_prints_and_leaves_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["exec", write(DRIVE), "--seed", "3", "--sim", "mujoco", "--rate", "max", "-o", "out"]
    assert main(arguments) == 0, capsys.readouterr().err
    here = capsys.readouterr()
    files = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    for path in Path("out").iterdir():
        path.unlink()
    assert main([*arguments, "--on", NAME]) == 0
    assert same(capsys.readouterr().out) == same(here.out)
    assert {path.name for path in Path("out").iterdir()} == files.keys()
    assert Path("out/top_down.png").read_bytes() == files["top_down.png"]


def test_json_option_prints_the_result_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(FAILING), "--on", NAME, "--clock", "virtual", "--json", "--seed", "5"]) == 1
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert (found["status"], found["scenario"], found["seed"]) == ("failed", "broken", 5)
    assert found["source"] == "test.osc:9:13"
    assert "so far" in err


def test_files_beside_the_scenario_are_sent_and_output_files_downloaded(
    capsys: pytest.CaptureFixture[str],
) -> None:
    write("action write_output:\n    text: string\naction break_down\n", "seoro.libraries/mine.osc")
    write(PYTHON, "seoro.libraries/mine.py")
    write("struct unused\n", "common/other.osc")
    text = 'import osc.mine\nimport "common/other.osc"\nscenario main:\n    do write_output("hello")\n'
    assert main(["exec", write(text), "--on", NAME, "-o", "out"]) == 0, capsys.readouterr().err
    assert Path("out/left.txt").read_text() == "hello"
    assert re.search(r"out/left\.txt +what was left", capsys.readouterr().out)


def test_a_fault_of_an_action_is_reported_as_in_a_local_run(capsys: pytest.CaptureFixture[str]) -> None:
    write("action write_output:\n    text: string\naction break_down\n", "seoro.libraries/mine.osc")
    write(PYTHON, "seoro.libraries/mine.py")
    file = write("import osc.mine\nscenario main:\n    do break_down()\n")
    assert main(["exec", file, "--on", NAME, "-o", "out"]) == 3
    err = capsys.readouterr().err
    assert "ValueError: broken" in err
    assert "`--debug` shows the traceback" in err
    assert Path("out/log.txt").read_text().startswith("about to break")
    assert main(["exec", file, "--on", NAME, "--debug"]) == 3
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_a_missing_permission_is_an_error_of_the_scenario(capsys: pytest.CaptureFixture[str]) -> None:
    file = write('import osc.helpers\nscenario main:\n    do run_process("ls")\n')
    assert main(["exec", file, "--on", NAME, "-o", "out"]) == 2
    err = capsys.readouterr().err
    assert "test.osc:3:8" in err
    assert "--allow run_process" in err
    assert 'errors="1"' in Path("out/test.xml").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--stop-if-lost", "3"], "`--stop-if-lost` is for runs on executors"),
        (["--executor", "tcp/127.0.0.1:1"], "`--executor` is for runs on executors"),
        (["--on", "other"], "unknown executor 'other'"),
        (["--on", NAME, "--sim", "mujoco", "--world", "hall.yaml"], "cannot read the world file"),
        (["--on", NAME, "--executor", "tcp/127.0.0.1:1"], "nothing answers there"),
        (["--on", NAME, "--executor", "nonsense"], "'nonsense' is an invalid endpoint"),
    ],
)
def test_invalid_options_are_rejected(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["exec", write(HELLO), *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_scenario_from_stdin_runs_as_here(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write("struct thing\n", "common/things.osc")
    text = 'import "common/things.osc"\n' + FAILING
    results = []
    for arguments in ([], ["--on", NAME]):
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
        status = main(["exec", "-", "--seed", "3", "--clock", "virtual", *arguments])
        out, err = capsys.readouterr()
        results.append((status, same(out), same(err)))
    assert results[0][0] == 1
    assert "<stdin>" in results[0][2]
    assert results[1] == results[0]


PARAMETERS = """import osc.helpers
scenario first:
    count: int = 1
    distance: length with:
        keep(it in [1m..2m])
    do serial:
        log("{count}")
        wait elapsed(1s)
scenario second:
    do serial:
        log("second")
"""


@pytest.mark.parametrize(
    ("options", "status"),
    [
        (["--scenario", "first"], 0),
        (["--scenario", "second"], 0),
        (["--scenario", "third"], 2),
        ([], 2),
        (["--scenario", "first", "--set", "count=7", "--set", "distance=1500mm"], 0),
        (["--scenario", "first", "--set", "count=1m"], 2),
        (["--scenario", "first", "--set", "distance=3m"], 2),
        (["--scenario", "first", "--params", "values.yaml"], 0),
        (["--scenario", "first", "--params", "missing.yaml"], 2),
        (["--scenario", "first", "--clock", "real", "--timeout", "0.3"], 3),
        (["--scenario", "first", "--clock", "sim"], 2),
        (["--scenario", "first", "--video-follow", "cart"], 2),
        (["--scenario", "first", "--world", "maze"], 2),
        (["--scenario", "first", "--json"], 0),
        (["--scenario", "first", "--live-tree"], 0),
    ],
)
def test_options_have_the_same_effect_as_in_a_local_run(
    options: list[str], status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    write("first:\n  count: 5\n", "values.yaml")
    arguments = ["exec", write(PARAMETERS), "--seed", "3", "--trace", "t.jsonl", "--junit", "t.xml", *options]
    if "--clock" not in options:
        arguments += ["--clock", "virtual"]
    results = []
    for where in ([], ["--on", NAME]):
        Path("t.jsonl").unlink(missing_ok=True)
        assert main([*arguments, *where]) == status
        out, err = capsys.readouterr()
        trace = Path("t.jsonl").read_text() if Path("t.jsonl").exists() else ""
        records = [json.loads(line) for line in trace.splitlines()]
        for record in records:
            record.pop("wall")
        timed = "--timeout" in options  # when that is up differs
        results.append((without_times(out), without_times(err), [] if timed else records))
    assert results[1] == results[0]


def without_times(text: str) -> str:
    """Replace the times of the machine's clock."""
    text = re.sub(r"(since|until) [\d.]+ s", r"\1 ?", text)
    return re.sub(r'[\d.]+ s (real|   )|"wall_duration": [\d.e-]+|[\d.]+ s of its clock', "?", text)


@pytest.mark.more
@pytest.mark.engine("mujoco")
def test_a_world_file_goes_with_all_that_it_names(capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(WORKSHOP, "workshop")
    arguments = ["exec", write(DRIVE), "--seed", "3", "--sim", "mujoco", "--world", "workshop/workshop.yaml"]
    arguments += ["--rate", "max", "-o", "out"]
    assert main(arguments) == 0, capsys.readouterr().err
    here, picture = capsys.readouterr().out, Path("out/top_down.png").read_bytes()
    shutil.rmtree("out")
    assert main([*arguments, "--on", NAME]) == 0, capsys.readouterr().err
    assert same(capsys.readouterr().out) == same(here)
    assert Path("out/top_down.png").read_bytes() == picture


@pytest.mark.more
@pytest.mark.engine("mujoco")
def test_a_lab_file_goes_with_its_world(capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(WORKSHOP, "labs/workshop")
    lab = "simulators:\n  hall: {simulator: mujoco, world: workshop/workshop.yaml}\n"
    write(lab + "robots:\n  robot: {in: hall, as: cart}\n", "labs/lab.yaml")
    arguments = ["exec", write(DRIVE), "--seed", "3", "--lab", "labs/lab.yaml", "--on", NAME]
    assert main(arguments) == 0, capsys.readouterr().err
    assert "with world 'workshop'" in capsys.readouterr().out


BRIEF = """import osc.types
scenario brief:
    do serial:
        wait elapsed(200ms)
"""


def kept(lab: RunningExecutor) -> set[str]:
    """Return the names of the runs and blobs that the executor stores."""
    return {str(path.name) for name in ("runs", "blobs") for path in (lab.folder / "state" / name).iterdir()}


def test_a_dry_run_prints_the_same_as_a_local_one_and_leaves_no_files(
    lab: RunningExecutor, capsys: pytest.CaptureFixture[str]
) -> None:
    before = kept(lab)
    arguments = ["exec", write(PARAMETERS + "# tried\n"), "--scenario", "first", "--seed", "3", "-n", "-o", "out"]
    assert main(arguments) == 0
    here = capsys.readouterr().out
    assert "distance = " in here
    assert main([*arguments, "--on", NAME]) == 0
    out, err = capsys.readouterr()
    size = Path("test.osc").stat().st_size
    assert (out, err) == (here, f"note: would send 1 file with {size} bytes\n")
    assert (kept(lab), Path("out").exists()) == (before, False)
    assert main([*arguments[:-3], "--clock", "virtual", "--on", NAME]) == 0
    capsys.readouterr()
    assert main([*arguments, "--on", NAME, "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["bundle"] == {"files": 1, "bytes": size, "known": 1}
    assert err == f"note: would send 1 file with {size} bytes; {NAME} already has 1 of them\n"
    assert len(kept(lab) - before) == 2  # the run and the file


@pytest.mark.parametrize(
    ("text", "options", "status", "message"),
    [
        ('import osc.helpers\nscenario main:\n    do run_process("ls")\n', [], 2, "test.osc:3:8"),
        (HELLO, ["--sim", "nonsense"], 2, "nonsense"),
        (HELLO, ["--set", "count=1"], 2, "count"),
        ("import osc.mine\nscenario main:\n    do write_output()\n", [], 3, "its process died"),
    ],
)
def test_a_dry_run_reports_missing_permissions(
    text: str,
    options: list[str],
    status: int,
    message: str,
    lab: RunningExecutor,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if "mine" in text:
        write("action write_output\n", "seoro.libraries/mine.osc")
        write("import os\nos._exit(1)\n", "seoro.libraries/mine.py")
    before = kept(lab)
    assert main(["exec", write(text + "# tried, too\n"), *options, "-n", "--on", NAME]) == status
    assert message in capsys.readouterr().err
    assert kept(lab) == before


FILMED = ("--rate", "max", "--video-size", "64x48", "--video-rate", "10", "--record-video")


def needs_films(engine: str) -> None:
    needs_pictures(engine)
    pytest.importorskip("av", reason="PyAV is not installed")


@pytest.mark.more
@pytest.mark.parametrize(
    ("engine", "options", "film"),
    [
        pytest.param("mujoco", ("-o", "out"), "out/video.mp4", marks=pytest.mark.engine("mujoco")),
        pytest.param("pybullet", ("-o", "out"), "out/video.mp4", marks=pytest.mark.engine("pybullet")),
        pytest.param("mujoco", (), "run.mp4", marks=pytest.mark.engine("mujoco")),
    ],
)
def test_a_run_leaves_its_film_as_one_here(
    engine: str, options: tuple[str, ...], film: str, capsys: pytest.CaptureFixture[str]
) -> None:
    needs_films(engine)
    place = [film] if film == "run.mp4" else []
    arguments = ["exec", write(DRIVE), "--seed", "3", "--sim", engine, *options, *FILMED, *place]
    found = []
    for where in ([], ["--on", NAME]):
        assert main([*arguments, *where]) == 0, capsys.readouterr().err
        pictures = Path(film).read_bytes()
        Path(film).unlink()
        left = {path.name for path in Path("out").iterdir()} if options else set()
        found.append((same(capsys.readouterr().out), left, pictures))
        shutil.rmtree("out", ignore_errors=True)
    assert found[1] == found[0]


@pytest.mark.more
@pytest.mark.engine("mujoco")
def test_a_video_is_downloaded_to_the_named_file(capsys: pytest.CaptureFixture[str]) -> None:
    needs_films("mujoco")
    film = "films/run.mp4"
    assert main(["exec", write(BRIEF), "--sim", "mujoco", "-o", "out", *FILMED, film, "--on", NAME]) == 0
    assert re.search(rf"  {film} +video of the run\n", capsys.readouterr().out)
    assert not Path("out/video.mp4").exists()
    assert main(["get", only_run("passed", capsys), "-o", "got"]) == 0
    assert Path("got/video.mp4").read_bytes() == Path(film).read_bytes()


@pytest.mark.engine("mujoco")
def test_an_invalid_view_of_a_video_is_reported_as_in_a_local_run(capsys: pytest.CaptureFixture[str]) -> None:
    needs_films("mujoco")
    arguments = ["exec", write(BRIEF), "--sim", "mujoco", *FILMED, "film.mp4", "--on", NAME]
    assert main([*arguments, "--video-follow", "ghost"]) == 2
    assert capsys.readouterr().err.startswith("error: unknown entity 'ghost'")
    assert not Path("film.mp4").exists()
    Path("film.mp4/video.mp4").mkdir(parents=True)
    assert main(arguments) == 2
    assert "cannot write film.mp4/video.mp4: is a folder" in capsys.readouterr().err


@pytest.mark.more
def test_an_executor_without_pyav_rejects_videos_before_files_are_sent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with executor(tmp_path, before="sys.modules['av'] = None") as lab:
        arguments = ["exec", write(DRIVE), "--sim", "mujoco", *FILMED, "film.mp4"]
        assert main([*arguments, "--on", NAME, "--executor", lab.endpoint]) == 2
    assert "the executor 'lab-a' cannot record videos: PyAV is not installed there" in capsys.readouterr().err
    assert list((tmp_path / "state/blobs").iterdir()) == []


def test_a_failed_download_makes_the_run_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    write("action write_output:\n    text: string\naction break_down\n", "seoro.libraries/mine.osc")
    write(PYTHON, "seoro.libraries/mine.py")
    text = 'import osc.mine\nscenario main:\n    do write_output("hello")\n'
    Path("out/left.txt").mkdir(parents=True)
    assert main(["exec", write(text), "--on", NAME, "-o", "out"]) == 3
    assert "cannot write out/left.txt: Is a directory; the run itself: passed" in capsys.readouterr().err
    assert 'errors="1"' in Path("out/test.xml").read_text()


def start(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "seoro", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_line(running: subprocess.Popen[str], text: str) -> None:
    assert running.stdout is not None
    while text not in (line := running.stdout.readline()):
        assert line, f"{text!r} was not printed"


def only_run(state: str, capsys: pytest.CaptureFixture[str]) -> str:
    """The id of the youngest run, which is in a state."""
    capsys.readouterr()
    assert main(["ps", "--json", "--limit", "1"]) == 0
    [found] = json.loads(capsys.readouterr().out)
    assert found["state"] == state
    run: str = found["run"]
    return run


def test_ctrl_c_stops_the_run_and_waits_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    with start("exec", write(LONG), "--on", NAME) as running:
        wait_for_line(running, "begun")
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=30)
    assert running.returncode == 130
    assert "Ctrl-C: stopping robots and cleaning up" in out
    assert "cancelled: interrupted by Ctrl-C" in err
    only_run("cancelled", capsys)


def test_a_run_survives_its_client_and_others_attach(capsys: pytest.CaptureFixture[str]) -> None:
    with start("exec", write(LONG), "--on", NAME) as running:
        wait_for_line(running, "begun")
        running.kill()
    run = only_run("running", capsys)
    with start("attach", run[:10], "--json") as attached:
        assert attached.stderr is not None
        while "begun" not in attached.stderr.readline():
            pass
        attached.send_signal(signal.SIGINT)
        attached.communicate(timeout=30)
    assert attached.returncode == 130
    only_run("running", capsys)
    with start("attach", run[:10]) as attached:
        wait_for_line(attached, "begun")
        assert main(["stop", run[:10]]) == 0
        assert capsys.readouterr().out == f"run {run[:8]}: cancelled\n"
        attached.communicate(timeout=30)
    assert attached.returncode == 4


@pytest.mark.more
def test_stop_mine_stops_only_runs_of_this_user(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with executor(tmp_path, "--jobs", "2") as lab:
        where = "--executor", lab.endpoint
        with start("exec", write(LONG), "--on", NAME, *where) as mine:
            wait_for_line(mine, "begun")
            monkeypatch.setattr("seoro.cli.stop_command.whoami", lambda: "somebody@else")
            assert main(["stop", "--mine", *where]) == 0
            assert capsys.readouterr().out == "you have no active runs\n"
            monkeypatch.undo()
            assert main(["stop", "--mine", *where]) == 0
            assert capsys.readouterr().out.endswith(": cancelled\n")
            mine.communicate(timeout=30)
    assert mine.returncode == 4


@pytest.mark.more
def test_a_run_that_is_stopped_while_it_waits_never_begins(tmp_path: Path) -> None:
    with executor(tmp_path) as lab:
        where = "--executor", lab.endpoint
        with start("exec", write(LONG), "--on", NAME, *where) as first:
            wait_for_line(first, "begun")
            with start("exec", write(HELLO, "hello.osc"), "--on", NAME, *where) as waiting:
                assert waiting.stderr is not None
                note = waiting.stderr.readline()
                assert "is queued on" in note
                waiting.send_signal(signal.SIGINT)
                out, err = waiting.communicate(timeout=30)
            first.send_signal(signal.SIGINT)
            first.communicate(timeout=30)
    assert waiting.returncode == 130
    assert err == "cancelled: interrupted by Ctrl-C\n"
    assert "hello\n" not in out


def test_a_run_that_is_over_is_looked_at_fetched_and_removed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(HELLO), "--on", NAME, "--seed", "9"]) == 0
    printed = capsys.readouterr().out
    run = only_run("passed", capsys)
    assert main(["ps"]) == 0
    assert re.search(rf"^{run[:8]} +{NAME} +passed .* test\.osc$", capsys.readouterr().out, re.MULTILINE)
    assert main(["logs", run]) == 0
    assert re.search(r"seed 9\n\n.*hello\n\npassed\n$", capsys.readouterr().out, re.DOTALL)
    assert main(["attach", run, "-o", "out"]) == 0
    assert same(capsys.readouterr().out).startswith(same(printed))
    assert {path.name for path in Path("out").iterdir()} == {"trace.jsonl", "test.xml", INDEX}
    assert main(["get", run]) == 0
    assert capsys.readouterr().out == f"{run[:8]}/trace.jsonl\n"
    assert Path(run[:8], "trace.jsonl").read_bytes() == Path("out/trace.jsonl").read_bytes()
    assert main(["stop", run]) == 0
    assert "has already ended: passed" in capsys.readouterr().out
    assert main(["rm", run]) == 0
    capsys.readouterr()
    assert main(["attach", run]) == 2
    assert f"unknown run '{run}'" in capsys.readouterr().err


# ---------------------------------------------------------------- serve


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--listen", "tcp/0.0.0.0:7470"], "is outside this machine"),
        (["--listen", "tcp/[::]:7470"], "is outside this machine"),
        (["--connect", "tcp/192.168.0.7:7470"], "is outside this machine"),
        (["--listen", "tcp/127.0.0.1.example.org:7470"], "is outside this machine"),
        (["--name", "Lab A"], "invalid name 'Lab A' of an executor"),
        (["--allow", "everything"], "unknown permission 'everything'"),
    ],
)
def test_invalid_options_of_serve_are_rejected(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["serve", "--folder", "state", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_folder_or_endpoint_in_use_is_reported(lab: RunningExecutor, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", "--folder", str(lab.folder / "state"), "--listen", "tcp/127.0.0.1:1"]) == 2
    assert "another executor uses the folder" in capsys.readouterr().err
    assert main(["serve", "--folder", "state", "--listen", "unixsock-stream//nowhere/at/all"]) == 2
    assert "cannot listen on" in capsys.readouterr().err
