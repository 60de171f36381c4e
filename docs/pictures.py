"""Make the pictures of the documentation anew: `python docs/pictures.py`, or `make pictures`.

Each picture is an output of a run in MuJoCo with a fixed seed. Those of the tutorial are of files on its pages.
The heat map of the localisation experiment comes from a campaign of 360 runs.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from PIL import Image

ROOT: Final = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tests.tools.code_blocks import blocks_in  # noqa: E402

if TYPE_CHECKING:
    from playwright.sync_api import Page

SEORO: Final = str(Path(sys.executable).with_name("seoro"))
IMAGES: Final = ROOT / "docs" / "images"
SIZE: Final = (320, 240)  # [pixels] of each phase of `pick_and_place`


def run(folder: Path, scenario: str, world: str) -> None:
    """Run a scenario, with its output in a folder.

    Args:
        folder: New folder.
        scenario: Path of the scenario in the project.
        world: Name or file of the world.

    Raises:
        CalledProcessError: The scenario did not pass.
    """
    arguments = ["--sim", "mujoco", "--world", world, "--rate", "max", "--seed", "0", "-o", str(folder)]
    _call(SEORO, "exec", scenario, *arguments)


def plot(scenario: str, world: str) -> Callable[[Path], Path]:
    """Return a function that runs a scenario and returns the plot of the run."""

    def draw(folder: Path) -> Path:
        run(folder, scenario, world)
        return folder / "top_down.png"

    return draw


def tutorial(page: str, scenario: str) -> Callable[[Path], Path]:
    """Return a function that runs a scenario of a page of the tutorial, and returns the plot of the run."""

    def draw(folder: Path) -> Path:
        _write_files(page, folder)
        for script in folder.glob("draw_*.py"):
            _call(sys.executable, script.name, folder=folder)
        _call(SEORO, "exec", scenario, "--rate", "max", "--seed", "1", "-o", "out", folder=folder)
        return folder / "out" / "top_down.png"

    return draw


def sweep(folder: Path) -> Path:
    """Return a picture of the first charts of the sweep of the tutorial."""
    _call(SEORO, "new", str(folder))
    options = (
        "--vary",
        "goal.x in [-1m..3m]",
        "--strategy",
        "latin",
        "--runs",
        "20",
        "--seed",
        "1",
        "-o",
        "sweep",
    )
    _call(SEORO, "campaign", "run", "scenarios/deliver.osc", *options, statuses=(1,), folder=folder)
    path = folder / "many_runs.png"
    with _browsing(height=1000) as page:
        page.goto((folder / "sweep" / "report.html").as_uri())
        page.wait_for_timeout(500)  # the charts are drawn
        page.screenshot(path=path)
    return path


def report(folder: Path) -> Path:
    """Return a picture of the report of the obstacle scenario, at a time when the robot drives."""
    run(folder, "scenarios/navigation/obstacle.osc", "maze")
    _call(SEORO, "report", str(folder))
    path = folder / "report.png"
    with _browsing(height=1060) as page:
        page.goto((folder / "report.html").as_uri())
        page.locator("html[data-ready]").wait_for(state="attached")
        page.get_by_label("Time in seconds").fill("18")
        page.get_by_label("Time in seconds").press("Enter")
        page.wait_for_timeout(500)  # the map is drawn
        page.screenshot(path=path)
    return path


def pages(folder: Path) -> Path:
    """Return a picture of the page of the obstacle scenario in `seoro ui`."""
    run(folder, "scenarios/navigation/obstacle.osc", "maze")
    path = folder / "ui.png"
    command = (SEORO, "ui", str(folder), "--port", "0")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as site, _browsing(height=900) as page:
        try:
            assert site.stdout is not None
            page.goto(next(line.strip() for line in site.stdout if "token=" in line))
            page.get_by_role("link", name="example_simulation").click()
            page.get_by_label("Time in seconds").fill("18")
            page.get_by_label("Time in seconds").press("Enter")
            page.wait_for_timeout(1000)  # the map is drawn
            page.screenshot(path=path)
        finally:
            site.terminate()
    return path


def snapshot(folder: Path) -> Path:
    """Return the first picture of the camera scenario."""
    run(folder, "scenarios/cameras/snapshots.osc", "empty")
    return folder / "before.png"


def pick_and_place(folder: Path) -> Path:
    """Return the four phases of picking and placing, in two rows."""
    run(folder, "scenarios/manipulation/pick_and_place.osc", "arm_cell")
    sheet = Image.new("RGB", (2 * SIZE[0], 2 * SIZE[1]))
    for index, phase in enumerate(("1_approach", "2_grasp", "3_lift", "4_place")):
        with Image.open(folder / f"{phase}.png") as picture:
            sheet.paste(picture.resize(SIZE), (index % 2 * SIZE[0], index // 2 * SIZE[1]))
    path = folder / "pick_and_place.png"
    sheet.save(path)
    return path


def localisation(folder: Path) -> Path:
    """Return the heat map of the localisation experiment."""
    file = "scenarios/experiments/localisation.yaml"
    _call(SEORO, "campaign", "run", file, "--sim", "mujoco", "-o", str(folder), statuses=(0, 1))
    _call(sys.executable, "benchmarks/localisation_experiment.py", str(folder), "--simulator", "MuJoCo")
    return folder / "localisation.png"


PICTURES: Final[Mapping[str, Callable[[Path], Path]]] = {
    "obstacle": plot("scenarios/navigation/obstacle.osc", "maze"),
    "two_robots": plot("scenarios/experiments/two_robots.osc", "hall"),
    "first_drive": tutorial("first_scenario", "drive.osc"),
    "my_map": tutorial("my_map", "tour.osc"),
    "first_robot": tutorial("first_robot", "yard.osc"),
    "own_action": tutorial("own_action", "rounds.osc"),
    "many_runs": sweep,
    "workshop": plot("examples/workshop/deliver.osc", "examples/workshop/workshop.yaml"),
    "report": report,
    "ui": pages,
    "snapshot": snapshot,
    "pick_and_place": pick_and_place,
    "localisation": localisation,
}


def _write_files(page: str, folder: Path) -> None:
    """Write the files that a page of the tutorial shows."""
    for block in blocks_in(ROOT / "docs" / "tutorial" / f"{page}.md"):
        if block.name:
            path = folder / block.name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text)


@contextmanager
def _browsing(height: int) -> Iterator[Page]:
    """Open a page of Chromium, 1280 pixels wide and `height` pixels high."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - for some pictures only

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        yield chromium.new_page(viewport={"width": 1280, "height": height}, color_scheme="light")
        chromium.close()


def _call(*arguments: str, statuses: Sequence[int] = (0,), folder: Path = ROOT) -> None:
    """Run a command in a folder; raises `CalledProcessError` for other exit statuses."""
    done = subprocess.run(arguments, cwd=folder, stdout=subprocess.DEVNULL, check=False)
    if done.returncode not in statuses:
        raise subprocess.CalledProcessError(done.returncode, arguments)


def main(names: Sequence[str]) -> int:
    """Make the named pictures, by default all, and return the exit status."""
    unknown = [name for name in names if name not in PICTURES]
    if unknown:
        print(f"unknown picture {unknown[0]!r} (pictures: {', '.join(PICTURES)})", file=sys.stderr)
        return 2
    for name in names or PICTURES:
        with tempfile.TemporaryDirectory() as folder:
            made = PICTURES[name](Path(folder) / "out")
            shutil.copyfile(made, IMAGES / f"{name}.png")
        print(f"docs/images/{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
