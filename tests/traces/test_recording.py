"""Recordings of traces, read by independent packages."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seoro.cli.main import main
from sim_nodes.recording import Encoder
from tests.full_disk import run_on_full_disk
from tests.traces.trace_records import CELLS, LOST, MAP, POSE, RECORDS, trace

pytest.importorskip("foxglove", reason="the extra `recording` is not installed")
reader = pytest.importorskip("mcap.reader")
decoder = pytest.importorskip("mcap_protobuf.decoder")


def messages(path: Path) -> dict[str, list[tuple[float, Any]]]:
    """Return time since the start [s] and message, by topic, in the order of the file."""
    found: dict[str, list[tuple[float, Any]]] = {}
    with path.open("rb") as file:
        made = reader.make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        for schema, channel, message in made.iter_messages(log_time_order=False):
            if channel.message_encoding == "json":
                data = json.loads(message.data)
            else:
                data = decoder.DecoderFactory().decoder_for("protobuf", schema)(message.data)
            found.setdefault(channel.topic, []).append(((message.log_time - 1780221600 * 10**9) / 1e9, data))
    return found


@pytest.fixture
def recorded(tmp_path: Path) -> dict[str, list[tuple[float, Any]]]:
    assert main(["trace", trace(tmp_path, RECORDS), "--mcap", str(tmp_path / "run.mcap")]) == 0
    return messages(tmp_path / "run.mcap")


def test_a_recording_has_the_whole_trace(recorded: dict[str, list[tuple[float, Any]]]) -> None:
    assert [each["kind"] for _, each in recorded["/trace"]] == [each["kind"] for each in RECORDS]
    assert [time for time, _ in recorded["/trace"]] == [each["t"] for each in RECORDS]


def test_frames_move_at_the_times_of_samples(recorded: dict[str, list[tuple[float, Any]]]) -> None:
    (time, first), _ = recorded["/tf"]
    assert time == 0.5
    assert [(each.parent_frame_id, each.child_frame_id) for each in first.transforms] == [
        ("map", "tb"),
        ("map", "tb_believed"),
    ]
    assert (first.transforms[0].translation.y, first.transforms[0].rotation.z) == (2.0, 0.7071)


def test_shapes_are_in_the_frames_of_their_entities(recorded: dict[str, list[tuple[float, Any]]]) -> None:
    (_, scene), (added, ball), (removed, deletion) = recorded["/scene"]
    entities = {each.id: each for each in scene.entities}
    assert {name: each.frame_id for name, each in entities.items()} == {"walls": "map", "post": "map", "tb": "tb"}
    [cube] = entities["walls"].cubes
    assert (cube.size.x, cube.color.g, cube.pose.position.x) == (1.0, 128 / 255, 1.0)
    assert len(entities["post"].triangles[0].points) == 3 * (2 + 6)
    assert (len(entities["tb"].cylinders), [each.pose.position.z for each in entities["tb"].spheres]) == (
        1,
        [0.5, 1.5],
    )
    assert (added, ball.entities[0].id, removed, deletion.deletions[0].id) == (0.6, "ball", 0.7, "ball")


def test_robots_with_odometry_only_say_so(tmp_path: Path) -> None:
    assert main(["trace", trace(tmp_path, [RECORDS[0], *LOST]), "--mcap", str(tmp_path / "run.mcap")]) == 0
    found = messages(tmp_path / "run.mcap")
    frames = [
        [(each.parent_frame_id, each.child_frame_id) for each in message.transforms] for _, message in found["/tf"]
    ]
    assert frames == [[("map", "tb/odom"), ("tb/odom", "tb")], [("map", "tb")]]
    texts = [[text.text for text in message.entities[0].texts] for _, message in found["/scene"]]
    assert texts == [["tb, by odometry"], []]


def test_maps_paths_scans_and_logs_are_messages(recorded: dict[str, list[tuple[float, Any]]]) -> None:
    [(_, grid)], [(_, plan)] = recorded["/map"], recorded["/tb/plan"]
    assert (grid.column_count, grid.row_stride, grid.data, grid.pose.position.x) == (3, 3, CELLS, -1.0)
    assert [each.position.y for each in plan.poses] == [0.0, 1.0]
    [(_, scan)] = recorded["/tb/lidar"]
    assert (scan.frame_id, scan.start_angle, scan.end_angle, list(scan.ranges)) == (
        "tb",
        -1.0,
        0.0,
        [1.0, float("inf"), 2.0],
    )
    (_, log), (_, end) = recorded["/log"]
    assert (log.message, log.level, log.file, log.line) == ("half way", 3, "main.osc", 7)
    assert (end.message, end.level) == ("failed: too late", 4)


def test_a_layout_is_beside_the_recording(tmp_path: Path) -> None:
    main(["trace", trace(tmp_path, RECORDS), "--mcap", str(tmp_path / "run.mcap")])
    layout = json.loads((tmp_path / "foxglove-layout.json").read_text())
    assert "3D!seoro" in layout["configById"]


def test_a_part_of_a_trace_has_the_same_times(tmp_path: Path) -> None:
    assert main(["trace", trace(tmp_path, RECORDS), "--from", "1", "--mcap", str(tmp_path / "run.mcap")]) == 0
    assert messages(tmp_path / "run.mcap")["/trace"][-1][1]["kind"] == "run.end"


def test_a_trace_without_times_of_the_machine_begins_at_zero(tmp_path: Path) -> None:
    file, shared = trace(tmp_path, RECORDS), str(tmp_path / "shared.jsonl")
    assert main(["redact", file, shared, "--drop", "wall"]) == 0
    assert main(["trace", shared, "--mcap", str(tmp_path / "run.mcap")]) == 0
    assert messages(tmp_path / "run.mcap")["/tf"][0][0] == 0.5 - 1780221600


def test_an_invalid_record_leaves_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = {**RECORDS[1], "map": {**MAP, "width": 10**9}}
    assert main(["trace", trace(tmp_path, [RECORDS[0], scene]), "--mcap", str(tmp_path / "run.mcap")]) == 2
    assert "invalid record 1 (`scene`): invalid size of a map" in capsys.readouterr().err
    assert {each.name for each in tmp_path.iterdir()} == {"trace.jsonl"}


def test_links_of_arms_have_frames(tmp_path: Path) -> None:
    turned = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]
    shape = {"kind": "box", "pose": [0.5, 0.0, 1.0, 0, 0, 0, 1], "size": [1.0, 0.1, 0.1], "link": "elbow"}
    hull = {"kind": "hull", "pose": POSE, "size": [], "corners": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    hull["triangles"] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    arm = {"name": "arm", "shapes": [shape, hull], "links": {"elbow": turned}}
    scene = {**RECORDS[1], "entities": [arm]}
    moved = {"kind": "poses", "t": 1.0, "time": 1.0, "entities": {}, "links": {"arm": {"elbow": POSE}}}
    assert main(["trace", trace(tmp_path, [RECORDS[0], scene, moved]), "--mcap", str(tmp_path / "run.mcap")]) == 0
    found = messages(tmp_path / "run.mcap")
    frames = [(time, frame) for time, message in found["/tf"] for frame in message.transforms]
    assert [(time, frame.parent_frame_id, frame.child_frame_id) for time, frame in frames] == [
        (0.0, "arm", "arm/elbow"),
        (1.0, "arm", "arm/elbow"),
    ]
    entities = {each.id: each for _, update in found["/scene"] for each in update.entities}
    assert len(entities["arm"].triangles[0].points) == 12
    [box] = entities["arm/elbow"].cubes
    # The link is turned by half a turn about z at (0, 0, 1).
    assert (box.pose.position.x, box.pose.position.z) == pytest.approx((-0.5, 0.0))
    assert abs(box.pose.orientation.z) == pytest.approx(1.0)


def film(path: Path, count: int) -> Path:
    encoder = Encoder(64, 48, 10)
    for number in range(count):
        encoder.add(np.full((48, 64, 3), 20 * number, dtype=np.uint8))
    encoder.finish()
    path.write_bytes(encoder.drain())
    return path


def test_a_recording_has_the_pictures_of_a_film(tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="the extra `video` is not installed")
    recorded = str(tmp_path / "run.mcap")
    video = film(tmp_path / "video.mp4", 12)
    assert main(["trace", trace(tmp_path, RECORDS), "--mcap", recorded, "--video", str(video)]) == 0
    pictures = messages(Path(recorded))["/video"]
    assert [time for time, _ in pictures] == pytest.approx([number / 10 for number in range(12)])
    assert {picture.format for _, picture in pictures} == {"h264"}
    decoder = av.CodecContext.create("h264", "r")
    shown = [frame for _, each in pictures for frame in decoder.decode(av.Packet(each.data))]
    shown += decoder.decode(None)
    assert len(shown) == 12
    assert shown[5].to_ndarray(format="rgb24").mean() == pytest.approx(100, abs=6)
    layout = json.loads((tmp_path / "foxglove-layout.json").read_text())
    assert layout["configById"]["Image!seoro"]["imageMode"]["imageTopic"] == "/video"
    assert "/tb/lidar" in layout["configById"]["3D!seoro"]["topics"]


def test_invalid_films_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("av", reason="the extra `video` is not installed")
    file, recorded = trace(tmp_path, RECORDS), tmp_path / "run.mcap"
    (tmp_path / "text.mp4").write_text("no film" * 100)
    for name in ("text.mp4", "missing.mp4"):
        assert main(["trace", file, "--mcap", str(recorded), "--video", str(tmp_path / name)]) == 2
        assert f"cannot read the film {tmp_path / name}: " in capsys.readouterr().err
        assert not recorded.exists()
    assert main(["trace", file, "--video", str(tmp_path / "text.mp4")]) == 2
    assert "`--video` needs `--mcap`" in capsys.readouterr().err


def test_a_full_disk_is_one_error(tmp_path: Path) -> None:
    trace, out = tmp_path / "trace.jsonl", tmp_path / "out.mcap"
    trace.write_text("".join(json.dumps({"seq": number, **each}) + "\n" for number, each in enumerate(RECORDS)))
    code = "import sys; from seoro.cli.main import main; sys.exit(main(sys.argv[1:]))"
    done = run_on_full_disk([sys.executable, "-c", code, "trace", str(trace), "--mcap", str(out)], 300)
    assert done.returncode == 2
    assert done.stderr.startswith(f"error: cannot write {out}: ")
    assert [path.name for path in tmp_path.iterdir()] == ["trace.jsonl"]
