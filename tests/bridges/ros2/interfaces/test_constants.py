"""Constants, which hashes do not cover, compared with the definitions of rosbags."""

import pytest

from seoro.bridges.ros2.interfaces import TypeStore


@pytest.mark.parametrize(("distribution", "count"), [("jazzy", 159), ("humble", 147)])
def test_constants_and_members_equal_those_of_rosbags(distribution: str, count: int) -> None:
    typesys = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed (extra `ros2`)")
    theirs = typesys.get_typestore(typesys.Stores[f"ROS2_{distribution.upper()}"]).fielddefs
    ours = TypeStore.bundled(distribution)
    both = [name for name in theirs if not name.startswith("rmw_dds_common/")]
    for name in both:
        constants, fields = theirs[name]
        structure = ours.structure(name)
        assert [(constant.name, constant.value) for constant in structure.constants] == [
            (constant, value) for constant, _, value in constants
        ], name
        assert [field.name for field in structure.fields] == [
            field for field, _ in fields if field != "structure_needs_at_least_one_member"
        ], name
    assert len(both) == count
