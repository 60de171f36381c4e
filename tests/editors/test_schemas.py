"""The YAML language server, which editors use, with the schemas of `seoro schema`."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.language_servers import Editor
from tests.node_js import needs_node, npm

TEXT = """\
# yaml-language-server: $schema=world.schema.json
name: hall
extent: [-5, -5, 5, 5]
wall_hight: 1
robots:
  - {name: one, robot: turtlebot4, pose: {x: 500}}
people:
  - {name: ana, wander: [0, 0, 1, 1], walk: {points: [[1, 1]]}}
"""


@needs_node
@pytest.mark.more
async def test_the_server_finds_mistakes_and_explains_keys(tmp_path: Path) -> None:
    (tmp_path / "package.json").write_text("{}")
    npm(tmp_path, "install", "yaml-language-server@1")
    assert main(["schema", "world", "--output-dir", str(tmp_path)]) == 0
    server = str(tmp_path / "node_modules/.bin/yaml-language-server")
    editor = Editor(tmp_path, (server, "--stdio"), "yaml")
    await editor.start()
    try:
        settings = {"yaml": {"validate": True, "hover": True, "schemaStore": {"enable": False}}}
        editor.notify("workspace/didChangeConfiguration", {"settings": settings})
        editor.open("hall.yaml", TEXT)
        while not (found := await editor.diagnostics("hall.yaml")):
            pass  # the first are those without the settings
        hover = await editor.ask_at("textDocument/hover", "hall.yaml", TEXT, "ro|bots:")
    finally:
        await editor.stop()
    lines = {each["range"]["start"]["line"]: each["message"] for each in found}
    assert "wall_hight" in lines[3]
    assert "100" in lines[5]
    assert lines[7] == "expected either `walk` or `wander`"
    assert "A robot" in hover["contents"]["value"]
