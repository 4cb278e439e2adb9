"""A mesh of another format (STL, OBJ, PLY, VTK) as the model of a deck that says nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.decks.keyword_file import Deck
from billow.decks.tables import Model, Nodes, Part, Shells
from billow.geometry.mesh_file import read_mesh


def mesh_model(path: Path) -> Model:
    """Nodes and cells counted from 1, parts from 1 in the order of their numbers. Raises InputError E-GEO-030, -031."""
    mesh = read_mesh(path)
    numbers = np.unique(mesh.part)
    titles = {number: name for name, number in mesh.part_names.items()}
    place = f"{path.name}:1"
    model = Model(Deck.of_mesh(path))
    points, count, cells = mesh.points, len(mesh.points), len(mesh.cells)
    model.nodes = Nodes(np.arange(1, count + 1), points, None, np.ones(count), np.zeros((count, 3), bool))
    model.shells = Shells(
        np.arange(1, cells + 1), np.searchsorted(numbers, mesh.part) + 1, np.where(mesh.cells >= 0, mesh.cells + 1, -1),
        np.zeros(cells), np.zeros(cells), np.full(cells, path.name, dtype=object), np.ones(cells, np.int64),
    )  # fmt: skip
    model.parts = {k: Part(k, titles.get(n, f"part {n}"), 0, 0, place) for k, n in enumerate(numbers.tolist(), 1)}
    return model
