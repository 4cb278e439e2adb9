"""`billow explore`: a surrogate, or a coupled model, as a page that answers while a slider moves."""

from __future__ import annotations

import hashlib
from dataclasses import asdict
from pathlib import Path

import numpy as np

from billow import __version__
from billow.base.errors import InputError
from billow.geometry.shapes.kinds import from_description
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.pages.html import page, web_file
from billow.pages.mesh import closed, colours, holes
from billow.pages.packed import pack, whole_numbers
from billow.results.blocks import mesh_of
from billow.rom.coupled.calibration_file import calibration_content
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.coupled.injury_metrics import METRICS, not_usable
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.design_space import distinct, from_unit, levelled, to_unit
from billow.rom.surrogate.judgement import require_won
from billow.rom.surrogate.prediction import LEVEL, describe_judgement
from billow.rom.surrogate.surrogate import Surrogate
from billow.rom.surrogate.surrogate_file import DAMAGED, network_content

NEEDS_FORCES = InputError.declare(
    "E-PAG-001",
    "this surrogate cannot be explored",
    where="{path}",
    why="it needs the contact forces of the previous time, which a page does not have",
    remedy="train one that needs none: billow train STUDY",
)

MODULES = (
    "elements.js", "tensors.js", "common_time.js", "networks.js", "bag.js", "standing.js", "scene.js", "section.js",
    "plot.js", "clock.js", "design.js", "obstacle.js", "impactor.js", "injury.js", "explorer.js",
)  # fmt: skip
LEAST_BOUND, PART_OF_WIDTH = 2e-4, 0.05
"""How far modes of half precision may change an answer: the larger of [m], and of the median half width."""
TRIED = 20
"""Designs at which that is measured."""


def explorer_page(surrogate: Surrogate, coupled: Coupled | None, path: Path) -> str:
    """The page. path: the file, whose SHA-256 it shows.

    IntegrityError E-ROM-004 if an obstacle is damaged; InputError E-PAG-001 if the surrogate needs forces,
    E-ROM-023 and E-CPL-007 if a verdict keeps it from answering.
    """
    if surrogate.forces is not None:
        raise NEEDS_FORCES(path=path)
    if not surrogate.insisted and coupled is None:
        require_won(surrogate.judgement, surrogate)
    if coupled is not None:
        coupled.require_judged()
    open_eyed = surrogate.despite_verdict()
    tensors, record = _of_bag(open_eyed, path)
    if coupled is not None:
        of_body, record["coupled"] = _of_coupled(coupled)
        # A motion follows from all shapes before: what each loses would add up, to 1 % of a velocity in half precision.
        tensors |= of_body | {"modes": np.stack([basis.modes for basis in surrogate.bases])}
    record["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    return page(f"{surrogate.title}: explorer", web_file("explorer.html"), MODULES, pack(tensors, record))


def explorer_in_report(surrogate: Surrogate, path: Path) -> str | None:
    """The page for a report, which says itself what the verdict is; None for a surrogate that needs forces."""
    return None if surrogate.forces is not None else explorer_page(surrogate.despite_verdict(), None, path)


def _of_bag(surrogate: Surrogate, path: Path) -> tuple[dict[str, np.ndarray], dict]:
    regression, intervals = surrogate.regression, surrogate.intervals
    modes = np.stack([basis.modes for basis in surrogate.bases])
    designs = surrogate.designs
    known = np.zeros((0, len(surrogate.parameters)))
    usual = largest = 0.0
    if designs is not None and (stands := surrogate.standing(designs[0])) is not None:
        known = to_unit(designs[[group[0] for group in distinct(designs, surrogate.parameters)]], surrogate.parameters)
        usual, largest = stands.usual, stands.largest
    part = None if surrogate.parts is None else holes(surrogate.parts.part, surrogate.parts.names)
    tensors = {
        "times": surrogate.times,
        "reference": surrogate.reference,
        "triangles": whole_numbers(surrogate.triangles.reshape(-1)),
        "hole": np.zeros(len(surrogate.triangles), np.uint8) if part is None else part,
        "modes": in_half_precision(surrogate, modes),
        "outputs.times": regression.outputs.times,
        "outputs.mean": regression.outputs.mean,
        "outputs.deviation": regression.outputs.deviation,
        "known": known,
        "colours": colours(),
        **network_content(regression),
    }
    if regression.clock is not None:
        tensors["clock.weights"] = regression.clock.weights
    obstacles = _obstacles(surrogate, tensors, path)
    interval = None
    if intervals is not None:
        mean = intervals.lost_by_node.mean(axis=1, keepdims=True)
        share = np.divide(intervals.lost_by_node, mean, out=np.zeros_like(intervals.lost_by_node), where=mean > 0.0)
        tensors |= {"lost_by_time": intervals.lost_by_time, "lost_by_node": share.astype(np.float32)}
        interval = {"level": LEVEL, "factors": intervals.factor(LEVEL).tolist()}
    record = {
        "title": surrogate.title,
        "recipe": surrogate.recipe,
        "parameters": [asdict(parameter) for parameter in surrogate.parameters],
        "runs": len(surrogate.runs),
        "verdict": describe_judgement(surrogate.judgement, "billow evaluate STUDY"),
        "lost": bool(surrogate.judgement and surrogate.judgement.lost),
        "interval": interval,
        "usual": usual,
        "largest": largest,
        "closed": closed(surrogate.triangles),
        "node": int(np.abs(modes[Z]).max(axis=0).argmax()),
        "obstacles": obstacles,
        "version": __version__,
    }
    return tensors, record


def _obstacles(surrogate: Surrogate, tensors: dict[str, np.ndarray], path: Path) -> list[dict]:
    """Put locked obstacles into `tensors`: a super-ellipsoid as the numbers that the design decides, any other as the
    mesh of its surface; returns what they are called, and which are not drawn because their surface would change."""
    low, high = surrogate.reference.min(axis=0).astype(float), surrogate.reference.max(axis=0).astype(float)
    told = []
    middle = from_unit(np.full((1, len(surrogate.parameters)), 0.5), surrogate.parameters)[0]
    for k, obstacle in enumerate(surrogate.obstacles):
        try:
            from_description(obstacle.at(middle))
        except (KeyError, TypeError, ValueError, IndexError) as error:
            why = f"the obstacle {obstacle.name} has no shape"
            raise DAMAGED(path=path, why=why, command="billow train FOLDER") from error
        ellipsoid = obstacle.like["kind"] == SuperEllipsoid.kind
        if ellipsoid:
            entries = ("radii", "degree", "center", "rotation")
            tensors[f"obstacle.{k}.affine"] = np.concatenate([obstacle.rows(entry) for entry in entries])
        elif not obstacle.varies:
            points, triangles = mesh_of(obstacle.like, 0.5 * (low + high), float((high - low).max()))
            tensors[f"obstacle.{k}.points"] = points.astype(np.float32)
            tensors[f"obstacle.{k}.triangles"] = whole_numbers(triangles.reshape(-1))
        told.append({"name": obstacle.name, "drawn": ellipsoid or not obstacle.varies})
    return told


def in_half_precision(surrogate: Surrogate, modes: np.ndarray) -> np.ndarray:
    """Modes as float16 if that changes no answer by more than its bound, else as they are: (3, modes, nodes)."""
    halves = modes.astype(np.float16)
    lost = modes - halves.astype(np.float32)
    unit = levelled(np.random.default_rng(0).random((TRIED, len(surrogate.parameters))), surrogate.parameters)
    designs = from_unit(unit, surrogate.parameters)
    bound = LEAST_BOUND
    if surrogate.intervals is not None:
        bound = max(bound, PART_OF_WIDTH * float(np.median(surrogate.half_width(designs[0], level=LEVEL))))
    difference = np.abs(np.einsum("rtck,ckn->rtcn", surrogate.coefficients(designs), lost)).max()
    return halves if difference <= bound else modes


def _of_coupled(coupled: Coupled) -> tuple[dict[str, np.ndarray], dict]:
    law, outputs, found = coupled.law, coupled.law.regression.outputs, coupled.calibration
    tensors = {
        "coupled.times": coupled.times,
        "coupled.gravity": coupled.gravity,
        "coupled.affine": coupled.impactor.affine,
        "coupled.state_mean": law.mean,
        "coupled.state_deviation": law.deviation,
        "coupled.force_mean": outputs.mean,
        "coupled.force_deviation": outputs.deviation,
    }
    tensors |= {f"coupled.{name}": array for name, array in network_content(law.regression).items()}
    lost: set[str] = set(METRICS.values())
    if found is not None:
        content = calibration_content(found)
        names = ("injury.weights", "injury.inverse", "injury.smallest", "injury.factors")
        tensors |= {f"coupled.{name}": content[name] for name in names}
        tensors["coupled.injury.from_motion"] = content["injury.from_motion"].astype(np.uint8)
        for shown, name in (("acceleration", "acceleration CFC 60"), ("velocity", "velocity")):
            tensors[f"half_width.{shown}"] = found.half_widths[name][:, Z].copy()
        lost = not_usable(found.of_injury)
    said = [f"Motion {describe_judgement(coupled.judgement, 'billow couple evaluate STUDY')}."]
    if found is not None:
        said.append(f"Injury {describe_judgement(found.of_injury, 'billow couple evaluate STUDY')}.")
    record = {
        "name": coupled.impactor.name,
        "injury": found is not None,
        "metrics": [{"name": name, "usable": name not in lost} for name in METRICS.values()],
        "verdict": " ".join(said),
    }
    return tensors, record
