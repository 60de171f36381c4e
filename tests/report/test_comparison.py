"""The page of `seoro compare`."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from seoro.cli.main import main
from seoro.report.comparison.picture import picture
from seoro.report.comparison.runs import compared_run, position
from tests.chromium import violations_of
from tests.report.traces import HOSTILE, REVERSED, records, write

if TYPE_CHECKING:
    from playwright.async_api import Browser


def written(folder: Path, *, turn: float, count: int, robot: str = "tb4", name: str = "main") -> None:
    """Write a run whose robots drive curves."""
    found: list[dict[str, Any]] = records(name, robot=robot)
    for record in found:
        if record["kind"] == "poses":
            time = record["t"]
            poses = {robot: [time, turn * math.sin(time)], "cart": [0.5 * time, 1.0 + turn], "box": [9.0, 9.0]}
            record["entities"] = {entity: [*pose, 0, 0, 0, 0, 1] for entity, pose in poses.items()}
        elif record["kind"] == "variable":
            record["value"] = count
    write(folder, found)
    measured = {"robot": {"distance": 4.0 + turn, "collisions": 0}, "world": "hall"}
    (folder / "measurements.json").write_text(json.dumps(measured))


def test_the_page_shows_what_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    written(Path("a"), turn=0.5, count=2)
    written(Path("b"), turn=1.0, count=3)
    assert main(["compare", "a", "b", "-o", "compare.html"]) == 1
    page = Path("compare.html").read_text()
    assert "<li>= count 2</li>" in page
    assert "<li>= count 3</li>" in page
    assert "Everything until <b>0.000 s</b> is equal" in page
    assert page.count("<polyline") == 4  # the box rests
    assert page.count('class="wall"') == 1
    assert '<th scope="row">robot.distance</th><td class="number">4.5</td>' in page
    assert '<td class="number">+0.5</td>' in page
    assert "robot.collisions" not in page
    assert "default-src 'none'; style-src 'sha256-" in page
    assert "<script" not in page

    assert main(["compare", "a", "a", "-o", "compare.html"]) == 0
    page = Path("compare.html").read_text()
    assert "None: everything happened at the same times." in page
    assert "Settings that differ" not in page


def test_hostile_texts_are_escaped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    written(Path("a"), turn=0.5, count=2, robot=HOSTILE, name=HOSTILE + REVERSED)
    written(Path("b"), turn=0.5, count=2, robot=HOSTILE * 200, name="main")
    assert main(["compare", "a", "b", "-o", "compare.html"]) == 1
    page = Path("compare.html").read_text()
    assert "<img" not in page
    assert "<script" not in page
    assert "\u202e" not in page


def test_a_page_is_not_written_over_a_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    written(Path("a"), turn=0.5, count=2)
    before = Path("a/trace.jsonl").read_bytes()
    assert main(["compare", "a", "a", "-o", "a/trace.jsonl"]) == 2
    assert "would overwrite" in capsys.readouterr().err
    assert Path("a/trace.jsonl").read_bytes() == before


def test_malformed_poses_and_shapes_are_skipped() -> None:
    box = {"kind": "box", "pose": [0] * 7, "size": [1, 1, 1]}
    shapes = [None, {}, box | {"size": ["x"]}, box | {"pose": [math.nan] * 7}]
    poses = [{"a": None, "b": [math.inf, 0], "c": [0, "1"], "d": [0, 0]}, {"d": [1, 1]}]
    found: list[dict[str, Any]] = [{"t": 0.0, "kind": "run.start"}, {"t": 0.0, "kind": "scene", "shapes": shapes}]
    found += [
        {"t": float(at), "kind": "poses", "time": float(at), "entities": each} for at, each in enumerate(poses)
    ]
    run = compared_run("x", found, None)
    drawn = "".join(picture(run, run, (0.5, 0.5)))
    assert list(run.paths) == ["d"]
    assert "polygon" not in drawn
    assert "nan" not in drawn
    assert position(run.paths["d"], 0.5) == (0, 0)


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("dark", [False, True])
async def test_the_page_is_readable_on_telephones_and_by_axe(browser: Browser, tmp_path: Path, dark: bool) -> None:
    written(tmp_path / "a", turn=0.5, count=2, name="long" * 40)
    written(tmp_path / "b", turn=1.0, count=3)
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b"), "-o", str(tmp_path / "c.html")]) == 1
    page = await browser.new_page(viewport={"width": 360, "height": 700}, color_scheme="dark" if dark else "light")
    problems: list[str] = []
    page.on("console", lambda message: problems.append(message.text))
    await page.goto((tmp_path / "c.html").as_uri())
    assert await page.evaluate("document.documentElement.scrollWidth") <= 360
    assert problems == []
    assert await violations_of(page) == []
    await page.close()
