import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.tf import (
    IDENTITY,
    FramesNotConnected,
    OutOfReach,
    Transform,
    TransformBuffer,
    UnknownFrame,
)
from tests.bridges.ros2.tf.frames import SECOND, at, close, matrix, transforms

Plain = dict[str, dict[str, float]]
TF_MESSAGE = "tf2_msgs/msg/TFMessage"


def robot() -> TransformBuffer:
    """map <- odom <- base_link <- laser, camera; each second, odom does 1 m, for three seconds."""
    buffer = TransformBuffer()
    buffer.put("base_link", "laser", at(0.1, 0.0, 0.2), None)
    buffer.put("/base_link", "/camera", at(0.0, 0.1), None)
    for second in range(4):
        buffer.put("odom", "base_link", at(float(second), yaw=0.5 * second), second * SECOND)
        buffer.put("map", "odom", at(0.0, 10.0), second * SECOND)
    return buffer


@settings(max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 1000), transforms()), min_size=1, max_size=12), st.data())
def test_lookups_equal_products_of_matrices(tree: list[tuple[int, Transform]], data: st.DataObject) -> None:
    buffer = TransformBuffer()
    in_root = [np.eye(4)]
    for number, (seed, transform) in enumerate(tree, 1):
        parent = seed % number
        buffer.put(f"f{parent}", f"f{number}", transform, None if seed % 2 else SECOND)
        in_root.append(in_root[parent] @ matrix(transform))
    frame, parent = (data.draw(st.integers(0, len(tree))) for _ in range(2))
    found = buffer.lookup(f"f{frame}", f"f{parent}")
    assert np.allclose(matrix(found.transform), np.linalg.inv(in_root[parent]) @ in_root[frame], atol=1e-4)


def test_transforms_between_samples_are_interpolated() -> None:
    found = robot().lookup("base_link", "odom", 3 * SECOND // 2)
    assert close(found.transform, at(1.5, yaw=0.75))
    assert found.stamp == 3 * SECOND // 2


def test_the_latest_lookup_uses_the_latest_common_time() -> None:
    buffer = robot()
    buffer.put("odom", "base_link", at(4.0), 4 * SECOND)
    assert buffer.lookup("laser", "map").stamp == 3 * SECOND
    assert buffer.lookup("laser", "odom").stamp == 4 * SECOND
    assert buffer.lookup("camera", "laser").stamp is None
    assert close(buffer.lookup("camera", "laser").transform, at(-0.1, 0.1, -0.2))
    assert close(buffer.lookup("map", "map").transform, IDENTITY)


def test_frames_off_the_path_do_not_affect_a_lookup() -> None:
    buffer = robot()
    buffer.put("odom", "base_link", at(9.0), 9 * SECOND)
    assert close(buffer.lookup("laser", "base_link", 9 * SECOND).transform, at(0.1, 0.0, 0.2))
    assert close(buffer.lookup("base_link", "odom", 9 * SECOND).transform, at(9.0))


def test_times_outside_of_the_history_are_refused() -> None:
    buffer = robot()
    with pytest.raises(
        OutOfReach, match=r"the pose of `base_link` in `odom` is known up to 3.000 s, 0.500 s from 3.500 s"
    ):
        buffer.lookup("laser", "map", 7 * SECOND // 2)
    for second in range(4, 25):
        buffer.put("odom", "base_link", at(float(second)), second * SECOND)
    with pytest.raises(OutOfReach, match=r"is known from 14.000 s, 13.000 s from 1.000 s"):
        buffer.lookup("base_link", "odom", SECOND)


def test_the_transform_history_is_bounded() -> None:
    buffer = TransformBuffer()
    for step in range(100_000):
        buffer.put("odom", "base_link", at(step * 0.01), step * SECOND // 100)
    assert buffer.find("base_link", "odom", 990 * SECOND) is not None
    assert buffer.find("base_link", "odom", 900 * SECOND) is None


def test_late_samples_are_sorted_by_time() -> None:
    buffer = TransformBuffer()
    for stamp in (0, 500, 1000, 250, 500):
        buffer.put("odom", "base_link", at(float(stamp)), stamp)
    assert close(buffer.lookup("base_link", "odom", 375).transform, at(375.0))


def test_unknown_frames_are_refused_with_similar_names() -> None:
    with pytest.raises(UnknownFrame, match=r"unknown frame `base_lnk`; did you mean `base_link`\?"):
        robot().lookup("base_lnk", "map")
    with pytest.raises(
        UnknownFrame, match="`gripper`; known frames: `base_link`, `camera`, `laser`, `map`, `odom`"
    ):
        robot().lookup("laser", "gripper")
    with pytest.raises(UnknownFrame, match="unknown frame `map`: no frame was published"):
        TransformBuffer().lookup("map", "odom")


def test_frames_of_different_trees_are_refused_with_both_trees() -> None:
    buffer = TransformBuffer()
    buffer.put("odom", "base_link", at(1.0), 0)
    buffer.put("earth", "map", at(1.0), None)
    for time_ in (None, 0):
        with pytest.raises(FramesNotConnected) as raised:
            buffer.lookup("base_link", "map", time_)
        assert str(raised.value) == (
            "`base_link` and `map` are not connected: `base_link` are below `odom`, `map` below `earth`"
        )


def test_a_frame_may_change_its_parent() -> None:
    buffer = TransformBuffer()
    buffer.put("table", "cup", at(1.0), 0)
    buffer.put("map", "table", at(10.0), None)
    buffer.put("map", "gripper", at(20.0), None)
    buffer.put("gripper", "cup", at(0.5), SECOND)
    assert close(buffer.lookup("cup", "map", 0).transform, at(11.0))
    assert close(buffer.lookup("cup", "map", SECOND // 2).transform, at(11.0))
    assert close(buffer.lookup("cup", "map").transform, at(20.5))
    assert buffer.parents == {"cup": "gripper", "gripper": "map", "table": "map"}


def test_cyclic_frames_are_refused() -> None:
    buffer = TransformBuffer()
    for parent, child in (("a", "b"), ("b", "c"), ("c", "a")):
        buffer.put(parent, child, at(1.0), 0)
    buffer.put("x", "y", at(1.0), 0)
    buffer.put("b", "below", at(1.0), 0)
    buffer.put("below", "further", at(2.0), 0)
    for frame, parent in (("b", "a"), ("a", "b"), ("a", "a"), ("below", "c")):  # ambiguous: depends on the path
        for stamp in (0, None):
            with pytest.raises(FramesNotConnected, match=r"the frames (`[abc]`(, )?){3} form a cycle"):
                buffer.lookup(frame, parent, stamp)
    assert close(buffer.lookup("further", "below").transform, at(2.0))
    with pytest.raises(FramesNotConnected):
        buffer.lookup("b", "y")


def test_a_time_that_jumps_back_drops_moving_frames_with_a_note() -> None:
    notes: list[str] = []
    buffer = TransformBuffer(on_note=notes.append)
    buffer.put("base_link", "laser", at(0.1), None)
    for second in range(60):
        buffer.put("odom", "base_link", at(float(second)), second * SECOND)
        buffer.put("map", "odom", at(0.0), second * SECOND)
    buffer.put("odom", "base_link", at(0.0), SECOND // 2)
    assert notes == ["time was set back from 59.000 s to 0.500 s (`base_link`); earlier transforms are dropped"]
    assert buffer.frames == ("base_link", "laser", "odom")
    assert buffer.lookup("laser", "odom").stamp == SECOND // 2


def test_transform_messages_are_added() -> None:
    types, buffer = TypeStore.bundled(), TransformBuffer()

    def message(parent: str, child: str, second: int, x: float) -> object:
        stamped = {
            "header": {"frame_id": parent, "stamp": {"sec": second}},
            "child_frame_id": child,
            "transform": {"translation": {"x": x}, "rotation": {"w": 1.0}},
        }
        return types.decode(TF_MESSAGE, types.encode(TF_MESSAGE, {"transforms": [stamped]}))

    buffer.put_message(message("base_link", "laser", 0, 0.1), is_static=True)
    buffer.put_message(message("odom", "base_link", 3, 2.0))
    found = buffer.lookup("laser", "odom")
    assert close(found.transform, at(2.1))
    assert found.stamp == 3 * SECOND


@pytest.mark.parametrize(
    ("transform", "problem"),
    [
        ({"rotation": {"w": 0.0}}, "invalid transform of `b` in `a`"),
        ({"rotation": {"w": 1.0}, "translation": {"x": float("nan")}}, "invalid transform of `b` in `a`"),
    ],
)
def test_invalid_transforms_are_skipped_and_reported_once(
    transform: dict[str, dict[str, float]], problem: str
) -> None:
    types, notes = TypeStore.bundled(), list[str]()
    buffer = TransformBuffer(on_note=notes.append)
    stamped = {"header": {"frame_id": "a"}, "child_frame_id": "b", "transform": transform}
    for _ in range(3):
        buffer.put_message(types.message(TF_MESSAGE, {"transforms": [stamped]}))
    assert (notes, buffer.frames) == ([problem], ())


def test_frames_without_a_name_or_within_themselves_are_skipped() -> None:
    notes: list[str] = []
    buffer = TransformBuffer(on_note=notes.append)
    buffer.put("a", "a", IDENTITY, 0)
    buffer.put("", "a", IDENTITY, 0)
    assert (len(notes), buffer.frames) == (2, ())


def test_a_thousand_lookups_take_less_than_a_tenth_of_a_second() -> None:
    buffer = robot()
    start = time.process_time()
    for step in range(1000):
        buffer.lookup("laser", "map", step * 3 * SECOND // 1000)
    assert time.process_time() - start < 0.1
