"""Delaunay triangulation by Qhull, through SciPy; what it answered is kept on disk.

To load SciPy's spatial package takes 0.2 s, a fifth of the start of a run, and most runs have a mesh that another run
had before. Same points and same SciPy, same triangles: the key is the SHA-256 of both, so nothing grows stale.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from pathlib import Path

import numpy as np
import scipy

from billow.base.cache_folder import cache_folder

MOST_KEPT = 64 * 2**20
"""Bytes on disk; the triangulations that were used longest ago go first."""

_SUM = hashlib.sha256().digest_size


def delaunay(points: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) int32, oriented either way, that fill the convex hull of points (n, 2) float64."""
    root = cache_folder()
    key = hashlib.sha256(f"SciPy {scipy.__version__} ".encode() + points.astype("<f8").tobytes()).hexdigest()
    path = None if root is None else Path(root, "triangulations", key)
    found = None if path is None else _read(path)
    if found is None:
        from scipy.spatial import Delaunay

        found = Delaunay(points).simplices
        if path is not None:
            with contextlib.suppress(OSError):  # a read-only home, a full disk: the next process makes it again
                _write(path, found)
    return found


def _read(path: Path) -> np.ndarray | None:
    """What was kept; None if there is nothing, or if it does not match its sum."""
    try:
        content = path.read_bytes() if path.is_file() else b""
        if not content or hashlib.sha256(content[_SUM:]).digest() != content[:_SUM]:
            return None
        os.utime(path)
    except OSError:
        return None
    return np.frombuffer(content[_SUM:], "<i4").reshape(-1, 3).astype(np.int32)


def _write(path: Path, triangles: np.ndarray) -> None:
    """Keep triangles under a name that appears when the file is whole, and forget the oldest if they are too many."""
    path.parent.mkdir(parents=True, exist_ok=True)
    data = triangles.astype("<i4").tobytes()
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(hashlib.sha256(data).digest() + data)
    os.replace(file.name, path)
    kept = []
    for other in path.parent.iterdir():
        with contextlib.suppress(OSError):  # another process forgot it
            kept.append((other.stat().st_mtime, other.stat().st_size, other))
    room = MOST_KEPT
    for _, size, other in sorted(kept, reverse=True):
        room -= size
        if room < 0:
            other.unlink(missing_ok=True)
