"""Suggested designs lie where the surrogate is unsure, apart from each other and from what is known."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.rom.learn import suggest as suggest_module
from billow.rom.learn.suggest import suggest, uncertainty
from billow.rom.surrogate.design_space import to_unit


def test_suggestions_are_inside_apart_and_repeatable(surrogate, dataset):
    known = dataset.design((*dataset.train, *dataset.test))
    rows = suggest(surrogate, 6, known)
    assert rows.shape == (6, 6)
    unit = to_unit(np.vstack([known, rows]), surrogate.parameters)
    assert ((unit >= 0.0) & (unit <= 1.0)).all()
    distances = np.linalg.norm(unit[:, None] - unit[None], axis=2)[len(known) :]
    assert np.sort(distances, axis=1)[:, 1].min() > 0.2
    np.testing.assert_array_equal(suggest(surrogate, 6, known), rows)
    np.testing.assert_array_equal(suggest(surrogate, 2, known), rows[:2])


def test_suggestions_are_less_sure_than_designs_at_large(surrogate, dataset):
    rows = suggest(surrogate, 8, dataset.design(dataset.train))
    low, high = (np.array([getattr(p, side) for p in surrogate.parameters]) for side in ("low", "high"))
    random = low + np.random.default_rng(2).random((200, 6)) * (high - low)
    assert uncertainty(surrogate, rows).mean() > 1.5 * uncertainty(surrogate, random).mean()


def test_uncertainty_decides_where(surrogate, monkeypatch):
    monkeypatch.setattr(
        suggest_module, "uncertainty", lambda s, designs: 1e-6 + (to_unit(designs, s.parameters)[:, 3] > 0.8)
    )
    unit = to_unit(suggest(surrogate, 10, []), surrogate.parameters)
    assert (unit[:, 3] > 0.8).all()


def test_suggestions_are_designs_that_the_study_may_have(surrogate):
    """Added designs are run as they stand: one between steps is refused by the case, one beyond a constraint is not."""

    def drawable(designs):
        designs = designs.copy()
        designs[:, 0] = np.round(designs[:, 0], 3)
        return designs[to_unit(designs, surrogate.parameters)[:, 1] < 0.3]

    rows = suggest(surrogate, 6, [], drawable=drawable)
    np.testing.assert_array_equal(rows, drawable(rows))
    with pytest.raises(InputError, match="constraints of the study"):
        suggest(surrogate, 6, [], drawable=lambda designs: designs[:5])


def test_none_is_refused(surrogate):
    with pytest.raises(InputError, match="E-ROM-021"):
        suggest(surrogate, 0, [])
