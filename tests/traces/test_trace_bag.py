"""Bags of traces, read by independent packages."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from tests.traces.test_recording import film
from tests.traces.trace_records import LOST, MOVING, POSE, RECORDS, trace

reader = pytest.importorskip("mcap.reader", reason="the extra `ros2` is not installed")
decoder = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support is not installed")
rosbags = pytest.importorskip("rosbags.rosbag2")


def bag(folder: Path, records: list[dict[str, Any]] = RECORDS) -> Path:
    assert main(["trace", trace(folder, records), "--bag", str(folder / "run")]) == 0
    return folder / "run"


def messages(folder: Path) -> dict[str, list[Any]]:
    """Return the decoded messages by topic."""
    found: dict[str, list[Any]] = {}
    with (folder / f"{folder.name}_0.mcap").open("rb") as file:
        for _, channel, _, message in reader.make_reader(
            file, decoder_factories=[decoder.DecoderFactory()]
        ).iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


def test_a_run_is_read_as_standard_messages(tmp_path: Path) -> None:
    found = messages(bag(tmp_path))
    assert set(found) == {
        "/trace", "/rosout", "/tf", "/map", "/markers", "/tb/odom", "/tb/plan", "/tb/lidar"
    }  # fmt: skip
    assert [json.loads(each.data)["kind"] for each in found["/trace"]] == [each["kind"] for each in RECORDS]
    assert [(each.level, each.msg) for each in found["/rosout"]] == [(30, "half way"), (40, "failed: too late")]
    frames = [(each.header.frame_id, each.child_frame_id) for tf in found["/tf"] for each in tf.transforms]
    assert frames == [("map", "tb"), ("map", "tb_believed"), ("tb", "tb/lidar")]
    [grid] = found["/map"]
    assert (grid.info.width, grid.info.height, list(grid.data)) == (3, 2, [0, 100, -1, 0, 0, 0])
    [scan] = found["/tb/lidar"]
    assert (scan.header.frame_id, scan.angle_min, list(scan.ranges)) == ("tb/lidar", -1.0, [1.0, math.inf, 2.0])
    [plan] = found["/tb/plan"]
    assert [(each.pose.position.x, each.pose.position.y) for each in plan.poses] == [(0, 0), (1, 1)]
    shown = found["/markers"][0].markers
    assert [(each.ns, each.id, each.type, each.header.frame_id) for each in shown] == [
        ("world", 0, 1, "map"),
        ("world", 1, 11, "map"),  # a prism
        ("tb", 0, 3, "tb"),  # a capsule
        ("tb", 1, 2, "tb"),
        ("tb", 2, 2, "tb"),
    ]
    assert shown[0].color.g == pytest.approx(128 / 255, abs=1e-3)
    assert len(shown[1].points) == 3 * (2 + 6)
    assert [each.pose.position.z for each in shown[3:]] == [0.5, 1.5]


def test_hulls_of_moving_links_are_triangles_in_their_frames(tmp_path: Path) -> None:
    hull = {"kind": "hull", "pose": [0.5, 0.0, 1.0, 0, 0, 0, 1], "size": [], "link": "elbow"}
    hull |= {"corners": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    hull |= {"triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}
    arm = {"name": "arm", "shapes": [hull], "links": {"elbow": [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]}}
    added = {
        "kind": "entity",
        "t": 0.5,
        "time": 0.5,
        "entity": {"name": "box", "shapes": [{**hull, "pose": POSE}]},
    }
    removed = {"kind": "poses", "t": 1.0, "time": 1.0, "entities": {}, "removed": ["box"]}
    scene = {**RECORDS[1], "shapes": [], "entities": [arm]}
    found = messages(bag(tmp_path, [RECORDS[0], scene, added, removed]))
    [elbow], [added_box], [deleted] = (each.markers for each in found["/markers"])
    assert (elbow.type, len(elbow.points), elbow.frame_locked) == (11, 12, True)
    assert elbow.header.frame_id == "arm/elbow"
    # The link is turned by half a turn about z at (0, 0, 1).
    assert (elbow.pose.position.x, elbow.pose.position.z) == pytest.approx((-0.5, 0.0))
    assert found["/tf"][0].transforms[0].child_frame_id == "arm/elbow"
    assert (added_box.ns, added_box.header.frame_id) == ("box", "box")
    assert (deleted.ns, deleted.id, deleted.action) == ("box", 0, 2)


def test_robots_with_odometry_only_have_a_frame_of_their_own(tmp_path: Path) -> None:
    found = messages(bag(tmp_path, [RECORDS[0], *LOST]))
    frames = [[(each.header.frame_id, each.child_frame_id) for each in tf.transforms] for tf in found["/tf"]]
    assert frames == [[("map", "tb/odom"), ("tb/odom", "tb")], [("map", "tb")]]
    assert [each.header.frame_id for each in found["/tb/odom"]] == ["tb/odom", "map"]
    [text], [deleted] = (each.markers for each in found["/markers"])
    assert (text.text, text.header.frame_id, deleted.action) == ("tb, by odometry", "tb", 2)


def test_films_are_pictures_in_jpeg(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    av = pytest.importorskip("av", reason="the extra `video` is not installed")
    video, file = film(tmp_path / "video.mp4", 4), trace(tmp_path, RECORDS)
    assert main(["trace", file, "--bag", str(tmp_path / "run"), "--video", str(video)]) == 0
    pictures = messages(tmp_path / "run")["/video/compressed"]
    assert [each.format for each in pictures] == ["jpeg"] * 4
    times = [each.header.stamp.sec + each.header.stamp.nanosec / 1e9 for each in pictures]
    assert times == pytest.approx([times[0] + number / 10 for number in range(4)], abs=1e-3)
    shown = av.CodecContext.create("mjpeg", "r").decode(av.Packet(bytes(pictures[3].data)))
    assert shown[0].to_ndarray(format="rgb24").mean() == pytest.approx(60, abs=6)
    (tmp_path / "text.mp4").write_text("no film" * 100)
    assert main(["trace", file, "--bag", str(tmp_path / "bad"), "--video", str(tmp_path / "text.mp4")]) == 2
    assert "cannot read the film" in capsys.readouterr().err
    assert not (tmp_path / "bad").exists()


def test_velocities_are_in_the_frame_of_the_robot(tmp_path: Path) -> None:
    [odometry] = messages(bag(tmp_path))["/tb/odom"]
    assert odometry.pose.pose.position.x == MOVING[0]
    # The robot faces +y of the map, in which it moves to +x.
    assert odometry.twist.twist.linear.x == pytest.approx(0.0, abs=1e-3)
    assert odometry.twist.twist.linear.y == pytest.approx(-0.1, abs=1e-3)


def test_rosbags_reads_the_folder(tmp_path: Path) -> None:
    with rosbags.Reader(bag(tmp_path)) as read:
        assert read.message_count == sum(topic.msgcount for topic in read.topics.values())
        assert read.topics["/tb/odom"].msgtype == "nav_msgs/msg/Odometry"
        assert read.duration > 0


def test_names_fit_topics(tmp_path: Path) -> None:
    records = [{"kind": "poses", "t": 0.0, "time": 0.0, "entities": {"3 b<ä>": MOVING}}]
    assert "/_3_b___/odom" in messages(bag(tmp_path, records))


@pytest.mark.parametrize(
    ("record", "message"),
    [
        ({"kind": "path", "t": 0.0, "entity": "tb", "points": [[1]]}, "invalid record 0 (`path`)"),
        ({"kind": "scene", "t": 0.0, "map": {"origin": [0, 0, 0]}}, "invalid record 0 (`scene`)"),
    ],
)
def test_an_invalid_record_leaves_no_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], record: dict[str, Any], message: str
) -> None:
    assert main(["trace", trace(tmp_path, [record]), "--bag", str(tmp_path / "run")]) == 2
    assert message in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["trace.jsonl"]


def test_an_existing_folder_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run").mkdir()
    assert main(["trace", trace(tmp_path, RECORDS), "--bag", str(tmp_path / "run")]) == 2
    assert "exists; expected a new folder" in capsys.readouterr().err
