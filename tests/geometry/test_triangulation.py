"""Triangulations and connected components are those of SciPy, kept or not; what is damaged on disk is made again."""

from __future__ import annotations

import os
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay

from billow.geometry import delaunay as kept
from billow.geometry.components import components
from billow.geometry.delaunay import delaunay


@given(st.integers(1, 60), st.integers(0, 2**32 - 1), st.floats(0.0, 2.0))
def test_components_are_those_of_scipy(count, seed, crowd):
    ends = np.random.default_rng(seed).integers(0, count, (int(crowd * count), 2))
    least = components(count, ends)
    links = coo_matrix((np.ones(len(ends)), ends.T), shape=(count, count))
    label = connected_components(links, directed=False)[1]
    first = [np.flatnonzero(label == one)[0] for one in label]
    assert least.tolist() == first


def test_a_long_chain_in_any_order_is_one_component():
    count = 20_000
    chain = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    shuffled = np.random.default_rng(1).permutation(count)[chain]
    assert not components(count, chain).any()
    assert not components(count, shuffled).any()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("BILLOW_CACHE", str(tmp_path))
    return tmp_path / "triangulations"


def cloud(seed: int, count: int = 50) -> np.ndarray:
    return np.random.default_rng(seed).random((count, 2))


def test_a_kept_triangulation_is_that_of_qhull_and_damage_is_no_answer(folder):
    points = cloud(0)
    expected = Delaunay(points).simplices
    for _ in range(2):
        found = delaunay(points)
        assert found.dtype == expected.dtype
        assert found.tolist() == expected.tolist()
    (file,) = folder.iterdir()
    sound = file.read_bytes()
    other = points.copy()
    other[0, 0] += 1e-16 + np.spacing(other[0, 0])
    delaunay(other)
    assert len(list(folder.iterdir())) == 2  # one bit of one point is another question
    for damaged in (b"", sound[:-1], sound[:40] + bytes([sound[40] ^ 1]) + sound[41:], sound + bytes(12)):
        file.write_bytes(damaged)
        assert delaunay(points).tolist() == expected.tolist()
        assert file.read_bytes() == sound


def test_what_is_kept_is_asked_for_and_not_made_again(folder, monkeypatch):
    points = cloud(0)
    expected = delaunay(points).tolist()
    monkeypatch.setattr("scipy.spatial.Delaunay", None)
    assert delaunay(points).tolist() == expected
    with pytest.raises(TypeError):
        delaunay(cloud(1))


def test_the_longest_unused_are_forgotten(folder, monkeypatch):
    first, second, third = cloud(0), cloud(1), cloud(2)
    delaunay(first)
    (old,) = folder.iterdir()
    delaunay(second)
    for file in folder.iterdir():
        os.utime(file, (time.time() - 100.0, time.time() - (200.0 if file == old else 100.0)))
    delaunay(first)  # used again
    monkeypatch.setattr(kept, "MOST_KEPT", 2 * old.stat().st_size + 200)
    delaunay(third)
    assert old in set(folder.iterdir())
    assert len(set(folder.iterdir())) == 2


def test_without_a_cache_everything_is_made(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("BILLOW_CACHE", str(tmp_path / "file"))
    assert delaunay(cloud(0)).tolist() == Delaunay(cloud(0)).simplices.tolist()
