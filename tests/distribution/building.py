"""Building distributions with the backend that pyproject.toml names, without a network."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Literal

ROOT = Path(__file__).parents[2]
TIME = "1700000000"  # [s] since 1970, of all files


def build(target: Path, kind: Literal["wheel", "sdist"], root: Path = ROOT) -> Path:
    """Build a distribution of a source tree into an empty folder; returns its path."""
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "--target", kind, "--directory", str(target)],
        cwd=root,
        env={**os.environ, "SOURCE_DATE_EPOCH": TIME},
        capture_output=True,
        check=True,
        timeout=120,
    )
    (built,) = target.iterdir()
    return built
