"""Pictures on meshes: read within bounds, and written as PNG for engines."""

from __future__ import annotations

import io
import math
import warnings

import numpy as np
from PIL import Image

from sim_nodes.views import Colour

FORMATS = ("PNG", "JPEG", "BMP", "TGA", "GIF", "TIFF")
MOST_PIXELS = 4096 * 4096  # of a file
LARGEST = 1024  # [pixels] edge of a picture in an engine; larger ones are scaled down
LEVEL = 3  # of compression


class UnusablePicture(ValueError):
    """A file is not a picture in a known format, damaged or too large; the message has the reason."""


def read_picture(data: bytes) -> Image.Image:
    """Read a picture without transparency, scaled down to `LARGEST`.

    Raises:
        UnusablePicture: The data is not a picture, or has too many pixels, which are not decoded.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            found = Image.open(io.BytesIO(data), formats=FORMATS)
            if math.prod(found.size) > MOST_PIXELS:
                raise Image.DecompressionBombError
        found.draft("RGB", (LARGEST, LARGEST))  # JPEG decodes to a smaller size at once
        picture = found.convert("RGB")
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise UnusablePicture(f"has more than {MOST_PIXELS:,} pixels") from error
    except Exception as error:  # each format has its own exceptions
        raise UnusablePicture(f"is damaged, or not in one of the formats {', '.join(FORMATS)}") from error
    picture.thumbnail((LARGEST, LARGEST))
    return picture


def to_png(picture: Image.Image) -> bytes:
    """Return a picture as a PNG file."""
    found = io.BytesIO()
    picture.convert("RGB").save(found, "PNG", compress_level=LEVEL)
    return found.getvalue()


def mean_colour(png: bytes) -> Colour:
    """Return the mean colour of a picture in PNG."""
    with Image.open(io.BytesIO(png), formats=("PNG",)) as picture:
        red, green, blue = np.asarray(picture, dtype=np.float64).reshape(-1, 3).mean(axis=0) / 255.0
    return float(red), float(green), float(blue), 1.0
