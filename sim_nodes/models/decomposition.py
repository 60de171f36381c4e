"""Concave meshes as convex pieces, by approximate convex decomposition (CoACD, Wei et al. 2022).

It runs in a process of its own, `python -m sim_nodes.models.decomposition`, with one thread: so it ends in time,
and other threads neither change the pieces nor slow it down.
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np
import trimesh

from sim_nodes.models.meshes import Mesh
from sim_nodes.models.xml_reading import invalid

THRESHOLD = 0.05  # largest concavity of a piece, as a share of the size of the mesh
MAX_PIECES = 64  # of a mesh
MAX_FACES = 20_000  # of a mesh; the time grows with them
SEED = 0  # of the search, so that pieces are the same on every load
TIMEOUT = 120.0  # [s] for one mesh


def decomposed(mesh: Mesh) -> list[Mesh]:
    """Split a mesh into convex pieces; a convex one is its only piece.

    Raises:
        RequestRefused: coacd is not installed or fails, or the mesh has too many triangles.
    """
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces)  # merges equal corners, which STL repeats
    if solid.is_convex:
        return [mesh]
    if find_spec("coacd") is None:
        raise invalid("`decompose` needs coacd: pip install 'seoro[coacd]'")
    if len(mesh.faces) > MAX_FACES:
        raise invalid(f"a mesh to decompose has {len(mesh.faces)} triangles; expected at most {MAX_FACES}")
    given = io.BytesIO()
    np.savez(given, vertices=solid.vertices, faces=solid.faces)
    command = [sys.executable, "-m", "sim_nodes.models.decomposition"]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command, input=given.getvalue(), capture_output=True, env=environment, timeout=TIMEOUT, check=True
        )
    except subprocess.TimeoutExpired as error:
        raise invalid(f"decomposing a mesh takes more than {TIMEOUT:g} s; simplify it") from error
    except subprocess.CalledProcessError as error:
        raise invalid(f"coacd cannot decompose a mesh with {len(mesh.faces)} triangles") from error
    return [Mesh(vertices, faces, mesh.colour) for vertices, faces in _pieces(np.load(io.BytesIO(done.stdout)))]


def _pieces(arrays: Any) -> Iterator[tuple[Any, Any]]:
    """Yield vertices and faces of each piece, which follow each other."""
    names = [f"arr_{index}" for index in range(len(arrays.files))]
    for vertices, faces in zip(names[::2], names[1::2], strict=True):
        yield arrays[vertices], arrays[faces]


def main() -> None:
    """Decompose the mesh of the standard input, and write the pieces to the standard output."""
    import coacd  # noqa: PLC0415 - an extra

    given = np.load(io.BytesIO(sys.stdin.buffer.read()))
    coacd.set_log_level("off")
    mesh = coacd.Mesh(given["vertices"], given["faces"])
    pieces = coacd.run_coacd(mesh, threshold=THRESHOLD, max_convex_hull=MAX_PIECES, seed=SEED)
    found = io.BytesIO()
    np.savez(found, *(np.asarray(array) for piece in pieces for array in piece))
    sys.stdout.buffer.write(found.getvalue())


if __name__ == "__main__":
    main()
