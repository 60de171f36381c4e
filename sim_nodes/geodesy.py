"""Positions on the earth: from a local tangent plane (east, north, up) to WGS 84.

Constants: NIMA TR8350.2, Department of Defense World Geodetic System 1984. Geodetic coordinates by the formula of
Bowring [1976, Transformation from spatial to geographical coordinates], repeated until it is exact.
"""

from __future__ import annotations

import math

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Vector

SEMI_MAJOR = 6_378_137.0  # [m]
FLATTENING = 1.0 / 298.257223563
SEMI_MINOR = SEMI_MAJOR * (1.0 - FLATTENING)
FIRST, SECOND = FLATTENING * (2.0 - FLATTENING), (SEMI_MAJOR / SEMI_MINOR) ** 2 - 1.0  # squared eccentricities
REPETITIONS = 3  # the first one is off by less than 1e-11 rad near the ground


@dataclass(frozen=True)
class GeoPoint:
    """A point in WGS 84."""

    latitude: float  # [rad]
    longitude: float  # [rad]
    altitude: float  # [m] above the ellipsoid


def earth_centred(point: GeoPoint) -> Array:
    """Return earth-centred, earth-fixed coordinates [m], shape (3,)."""
    sin, cos = math.sin(point.latitude), math.cos(point.latitude)
    normal = SEMI_MAJOR / math.sqrt(1.0 - FIRST * sin**2)
    across = (normal + point.altitude) * cos
    return np.array(
        [
            across * math.cos(point.longitude),
            across * math.sin(point.longitude),
            (normal * (1.0 - FIRST) + point.altitude) * sin,
        ]
    )


def from_earth_centred(position: Array) -> GeoPoint:
    """Return the point of earth-centred, earth-fixed coordinates [m], not near the centre of the earth."""
    x, y, z = position.tolist()
    across = math.hypot(x, y)
    reduced = math.atan2(z * SEMI_MAJOR, across * SEMI_MINOR)
    latitude = 0.0
    for _ in range(REPETITIONS):
        latitude = math.atan2(
            z + SECOND * SEMI_MINOR * math.sin(reduced) ** 3, across - FIRST * SEMI_MAJOR * math.cos(reduced) ** 3
        )
        reduced = math.atan2((1.0 - FLATTENING) * math.sin(latitude), math.cos(latitude))
    sin, cos = math.sin(latitude), math.cos(latitude)
    normal = SEMI_MAJOR / math.sqrt(1.0 - FIRST * sin**2)
    # Exact at all latitudes, also at the poles.
    altitude = across * cos + z * sin - SEMI_MAJOR**2 / normal
    return GeoPoint(latitude, math.atan2(y, x), altitude)


def from_local(origin: GeoPoint, offset: Vector) -> GeoPoint:
    """Return the point at an offset in the tangent plane of another point.

    Args:
        origin: The other point.
        offset: East, north, up [m].
    """
    lat, lon = origin.latitude, origin.longitude
    axes = np.array(
        [
            [-math.sin(lon), math.cos(lon), 0.0],
            [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)],
            [math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)],
        ]
    )
    return from_earth_centred(earth_centred(origin) + np.asarray(offset) @ axes)
