from __future__ import annotations

import io
import json
import math
import struct
import zlib
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.report.blocks import Blocks
from seoro.report.columns import Packed, integers, reals, small
from seoro.report.folder import Results
from seoro.report.frames import Frame
from seoro.report.page import NoRecords, write_report
from seoro.report.reading import Reading
from seoro.report.repeat import repeat_command
from tests.report.traces import HOSTILE, REVERSED, records, write


def test_columns_are_differences_in_planes() -> None:
    data = bytearray()
    packed = Packed(data.extend)
    packed.add("a", integers([5, 7, 4]))
    packed.add("b", reals([1.5]))
    packed.add("c", small([3, 4]))
    assert packed.layout == {"a": ("i4", 3), "b": ("f8", 1), "c": ("u1", 2)}
    planes = bytes(data)
    rows = zip(*(planes[index * 3 : index * 3 + 3] for index in range(4)), strict=True)
    assert [struct.unpack("<i", bytes(row))[0] for row in rows] == [5, 2, -3]
    assert planes[12:] == struct.pack("<d", 1.5) + b"\x03\x04"


def test_columns_of_one_value_are_stored_once() -> None:
    data = bytearray()
    packed = Packed(data.extend)
    packed.add("a", integers([5, 5, 5]))
    packed.add("b", reals([math.nan, math.nan]))
    packed.add("c", small())
    assert packed.layout == {"a": ("=i4", 3), "b": ("=f8", 2)}
    assert bytes(data[:4]) == struct.pack("<i", 5)
    assert len(data) == 12


def test_executions_of_a_behavior_share_a_row() -> None:
    reading = Reading()
    start = {"kind": "behavior.start", "t": 0, "type": "wait", "name": "wait", "source": "", "parent": None}
    lines = [{**start, "id": number, "path": f"main/serial[0]#{number}/wait[0]"} for number in range(3)]
    reading.read(io.BytesIO("\n".join(map(json.dumps, lines)).encode()))
    assert [(row.path, row.name) for row in reading.behaviors.rows] == [("main/serial[0]/wait[0]", "wait")]
    assert reading.behaviors.totals()[0] == {"running": 3}


def test_links_and_later_entities_are_part_of_the_data() -> None:
    found = records()
    at = next(number for number, each in enumerate(found) if each["kind"] == "poses")
    arm = {"name": "arm", "kind": "robot", "real": True, "shapes": []}
    added = {**found[at], "kind": "entity", "entity": arm}
    moved = {**found[at], "entities": {}, "links": {"arm": {"elbow": [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]}}}
    found[at:at] = [added, moved]
    reading = Reading()
    reading.read(io.BytesIO("\n".join(json.dumps({**each, "seq": n}) for n, each in enumerate(found)).encode()))
    written = bytearray()
    frame = Frame(reading, Results(), written.extend)
    data = json.loads(frame.text)
    assert data["links"] == [["arm", "elbow"]]
    assert data["layout"]["link.0.t"] == ["f8", 1]
    assert [each["name"] for each in data["scene"]["entities"]] == ["tb4", "arm"]


def test_the_map_of_a_later_scene_and_changing_frames_are_part_of_the_data() -> None:
    found = records()
    at = next(number for number, each in enumerate(found) if each["kind"] == "scene")
    arm = {"name": "arm", "kind": "robot", "shapes": []}
    lost, known = ({**found[at], "kind": "entity", "entity": each} for each in ({**arm, "frame": "odom"}, arm))
    found[at : at + 1] = [{**lost, "time": 0.0}, found[at], {**known, "time": 2.5}]
    reading = Reading()
    reading.read(io.BytesIO("\n".join(json.dumps({**each, "seq": n}) for n, each in enumerate(found)).encode()))
    assert reading.scene is not None
    assert reading.scene["world"] == "hall"
    assert {each["name"]: each.get("frames") for each in reading.scene["entities"]} == {
        "tb4": None,
        "arm": [[0.0, "odom"], [2.5, "map"]],
    }


def test_hostile_texts_are_escaped() -> None:
    output = io.StringIO()
    found = records(HOSTILE, log=HOSTILE + REVERSED, robot=HOSTILE)
    write_report(io.BytesIO("\n".join(map(json.dumps, found)).encode()), None, output)
    page = output.getvalue()
    assert "<img" not in page
    assert "\u202e" not in page
    assert page.count("<script>") == 1
    assert "default-src 'none'; script-src 'sha256-" in page


def test_records_lose_wall_times_and_numbers_that_count_on() -> None:
    lines = (
        b'{"seq": 3, "t": 0.5, "wall": "2026", "kind": "log"}',
        b'{"seq": 4, "t": 0.5, "wall": "2026", "kind": "log", "message": ", \\"wall\\": \\"2"}',
        b'{"seq": 7, "t": 0.6, "wall": "2026", "kind": "log"}',
        b'{"t": 0.6, "kind": "log"}',
    )
    trace, blocks, start = b"\n".join(lines), Blocks(), 0
    for seq, line in zip((3, 4, 7, 8), lines, strict=True):
        blocks.add(start, start + len(line), seq, 0.5, 0)
        start += len(line) + 1
    found = blocks[0].compressed(lambda start, size: trace[start : start + size])
    assert zlib.decompress(found).splitlines() == [
        b'{"seq": 3, "t": 0.5, "kind": "log"}',
        b'{"t": 0.5, "kind": "log", "message": ", \\"wall\\": \\"2"}',
        b'{"seq": 7, "t": 0.6, "kind": "log"}',
        b'{"t": 0.6, "kind": "log"}',
    ]


def test_a_report_needs_records() -> None:
    with pytest.raises(NoRecords, match="line 1: invalid JSON"):
        write_report(io.BytesIO(b"nonsense\n"), None, io.StringIO())


def test_a_report_of_a_pipe_is_that_of_a_file() -> None:
    class Pipe(io.BytesIO):
        def seekable(self) -> bool:
            return False

    trace = "\n".join(map(json.dumps, records())).encode()
    of_file, of_pipe = io.StringIO(), io.StringIO()
    write_report(io.BytesIO(trace), None, of_file)
    write_report(Pipe(trace), None, of_pipe)
    assert of_pipe.getvalue() == of_file.getvalue()


def test_the_command_repeats_parameters_and_constraints() -> None:
    start = {"file": "a b.osc", "scenario": "main", "seed": 3, "clock": "virtual", "overrides": {"n": "2"}}
    found = repeat_command({**start, "constraints": ["n > 1"]}, {})
    assert found == "seoro exec 'a b.osc' --scenario main --seed 3 --clock virtual --set n=2 --constrain 'n > 1'"


@pytest.mark.parametrize(("rate", "word"), [(None, "max"), (1.0, "1"), (0.5, "0.5")])
def test_the_command_repeats_the_rate(rate: float | None, word: str) -> None:
    start = {"file": "a.osc", "scenario": "main", "clock": "sim", **({} if rate is None else {"rate": rate})}
    assert repeat_command(start, {"simulator": "mujoco"}).endswith(f"--sim mujoco --rate {word}")


def test_seoro_report_writes_beside_the_trace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, records())
    assert main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"wrote {tmp_path}/report.html, 0.1 MB: open it in a browser\n"
    assert (tmp_path / "report.html").stat().st_size < 1_000_000


def test_several_runs_have_their_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [str(tmp_path / name) for name in ("1", "2")]
    for name in names:
        write(Path(name), records())
    assert main(["report", *names]) == 0
    assert all(Path(name, "report.html").is_file() for name in names)
    assert main(["report", *names, "-o", "one.html"]) == 2
    assert "`--output` is for one run" in capsys.readouterr().err


def test_a_killed_run_has_a_report_with_a_note(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trace = tmp_path / "killed.jsonl"
    trace.write_text("\n".join(map(json.dumps, records()[:-5])) + '\n{"seq"')
    assert main(["report", str(trace), "-o", str(tmp_path / "r.html")]) == 0
    assert "no `run.end`" in capsys.readouterr().err
    assert "Not ended: main" in (tmp_path / "r.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["folder"], "no trace.jsonl in the folder folder"),
        (["missing.jsonl"], "cannot read the trace missing.jsonl: No such file or directory"),
        (["bad.jsonl"], "invalid trace bad.jsonl: line 1: invalid JSON"),
        (["bad.jsonl", "-o", "bad.jsonl"], "the report would overwrite bad.jsonl"),
        (["bad.jsonl", "-o", "folder"], "cannot write folder: is a folder"),
    ],
)
def test_refusals(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    Path("bad.jsonl").write_text("nonsense\n")
    assert main(["report", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.jsonl", "folder"]


def test_exec_writes_a_report_on_request(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wait.osc").write_text("import osc.types\n\nscenario main:\n    do wait elapsed(1s)\n")
    assert main(["exec", "wait.osc", "--clock", "virtual", "--report"]) == 2
    assert main(["exec", "wait.osc", "--clock", "virtual", "--report", "-o", "out"]) == 0
    assert "Passed: main" in Path("out/report.html").read_text()
    assert main(["exec", "wait.osc", "--clock", "virtual", "-o", "out"]) == 0
    assert not Path("out/report.html").exists()
