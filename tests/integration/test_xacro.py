"""Scenarios spawn xacro files with arguments."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.cli.main import main

pytest.importorskip("xacro")
pytestmark = pytest.mark.engine("mujoco")

POST = """<robot name="post" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="side" default="0.1"/>
<xacro:arg name="height" default="1"/>
<link name="post"><collision><origin xyz="0 0 ${float('$(arg height)') / 2}"/>
<geometry><box size="$(arg side) $(arg side) $(arg height)"/></geometry></collision></link></robot>"""


@pytest.mark.parametrize(
    ("model", "arguments", "words"),
    [
        ("post.urdf.xacro", "side:=0.5, height:=2", "would overlap post"),
        ("post.urdf.xacro", "side", "invalid `xacro_arguments` 'side'; expected `key:=value`"),
        ("box.sdf", "side:=1", "expected a model in a .xacro file"),
    ],
)
def test_arguments_of_xacro_are_used_or_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str, model: str, arguments: str, words: str
) -> None:
    (tmp_path / "post.urdf.xacro").write_text(POST)
    file = tmp_path / "posts.osc"
    file.write_text(
        "import osc.gazebo\nscenario main:\n    post: sim_object\n    other: sim_object\n    do serial:\n"
        f"        post.spawn(pose_3d(position_3d(x: 1m)), 'file://{tmp_path}/post.urdf.xacro')\n"
        f"        other.spawn(pose_3d(position_3d(x: 1.2m)), 'file://{tmp_path}/{model}', "
        f"xacro_arguments: '{arguments}')\n"
    )
    assert main(["exec", str(file), "--connect", mujoco_node, "--world", "empty", "--rate", "max"]) == 1
    err = capsys.readouterr().err
    assert words in err
    assert f"{file}:7:9" in err
