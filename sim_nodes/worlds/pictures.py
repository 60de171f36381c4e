"""Pictures that world files name: floor plans, and heights of terrain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from seoro.files.inputs import Kind, open_input
from seoro.files.yaml_lines import FileError
from sim_nodes.geometry import Array

OPAQUE_16_BIT = 65535.0


def read_darkness(path: Path, what: str, most: int) -> Array:
    """Read the darkness of the pixels of a picture, 0 white to 1 black, shape (rows, columns), the top row first.

    Args:
        path: A PNG, PGM or JPEG file.
        what: Name of the picture in messages.
        most: Maximum number of pixels.

    Raises:
        FileError: The file is missing, of another format, damaged or too large.
    """
    try:
        with open_input(path, Kind.FLOOR_PLAN) as file, Image.open(file, formats=("PNG", "PPM", "JPEG")) as image:
            if image.width * image.height > most:
                raise FileError(
                    f"{path} has {image.width} by {image.height} pixels; expected at most {most} altogether"
                )
            return _darkness(image)
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise FileError(f"{path} has too many pixels; expected at most {most}") from error
    except UnidentifiedImageError as error:
        raise FileError(f"unsupported image format: {path}; expected PNG, PGM or JPEG") from error
    except (OSError, ValueError, SyntaxError) as error:  # exceptions of Pillow for broken files
        raise FileError(f"cannot read the {what} {path}: {error}") from error


def _darkness(image: Image.Image) -> Array:
    if image.mode.startswith("I"):
        return 1.0 - np.asarray(image, dtype=np.float64) / OPAQUE_16_BIT
    pixels = np.asarray(image.convert("RGBA"), dtype=np.float64) / 255.0
    # Transparent pixels show white paper.
    darkness: Array = (1.0 - pixels[:, :, :3].mean(axis=2)) * pixels[:, :, 3]
    return darkness
