"""A coupled file as one side of a comparison: its bag and the motion of its impactor."""

import numpy as np

from billow.apps.compare.differences import injuries
from billow.apps.compare.model_side import answer
from billow.injury.criteria import assess


def test_a_coupled_file_answers_with_shapes_and_curves(judged, free, tmp_path):
    path = judged.despite_verdict().save(tmp_path / "coupled.safetensors")
    values = free.design(free.test[:1])[0]
    design = {p.name: value for p, value in zip(judged.surrogate.parameters, values.tolist(), strict=True)}
    side = answer(path, "model", None, design)
    motion = judged.despite_verdict().deploy(design)
    name = judged.impactor.name
    np.testing.assert_array_equal(side.curves.find(name, "velocity"), motion.velocity)
    np.testing.assert_array_equal(side.curves.time, motion.times)
    assert side.curves.find(name, "centre").shape == side.curves.find(name, "acceleration").shape == motion.centre.shape
    assert injuries(side.curves)[name] == assess(motion.times, motion.velocity)
    moved = judged.surrogate.despite_verdict().predict(design)
    np.testing.assert_array_equal(side.fabric.points(3), judged.surrogate.reference + moved[3])
