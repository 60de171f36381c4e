"""Make the pictures of the documentation anew: `python docs/pictures.py`, or `make pictures`.

Each picture is an output of a run in MuJoCo with a fixed seed. The heat map of the localisation experiment comes
from a campaign of 360 runs.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from PIL import Image

SEORO: Final = str(Path(sys.executable).with_name("seoro"))
ROOT: Final = Path(__file__).parents[1]
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


def report(folder: Path) -> Path:
    """Return a picture of the report of the obstacle scenario, at a time when the robot drives."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - for this picture only

    run(folder, "scenarios/navigation/obstacle.osc", "maze")
    _call(SEORO, "report", str(folder))
    path = folder / "report.png"
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = chromium.new_page(viewport={"width": 1280, "height": 1060}, color_scheme="light")
        page.goto((folder / "report.html").as_uri())
        page.locator("html[data-ready]").wait_for(state="attached")
        page.get_by_label("Time in seconds").fill("18")
        page.get_by_label("Time in seconds").press("Enter")
        page.wait_for_timeout(500)  # the map is drawn
        page.screenshot(path=path)
        chromium.close()
    return path


def pages(folder: Path) -> Path:
    """Return a picture of the page of the obstacle scenario in `seoro ui`."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - for this picture only

    run(folder, "scenarios/navigation/obstacle.osc", "maze")
    path = folder / "ui.png"
    command = (SEORO, "ui", str(folder), "--port", "0")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as site, sync_playwright() as playwright:
        try:
            assert site.stdout is not None
            url = next(line.strip() for line in site.stdout if "token=" in line)
            chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            page = chromium.new_page(viewport={"width": 1280, "height": 900}, color_scheme="light")
            page.goto(url)
            page.get_by_role("link", name="example_simulation").click()
            page.get_by_label("Time in seconds").fill("18")
            page.get_by_label("Time in seconds").press("Enter")
            page.wait_for_timeout(1000)  # the map is drawn
            page.screenshot(path=path)
            chromium.close()
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
    "workshop": plot("examples/workshop/deliver.osc", "examples/workshop/workshop.yaml"),
    "report": report,
    "ui": pages,
    "snapshot": snapshot,
    "pick_and_place": pick_and_place,
    "localisation": localisation,
}


def _call(*arguments: str, statuses: Sequence[int] = (0,)) -> None:
    """Run a command in the project's root; raises `CalledProcessError` for other exit statuses."""
    done = subprocess.run(arguments, cwd=ROOT, stdout=subprocess.DEVNULL, check=False)
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
