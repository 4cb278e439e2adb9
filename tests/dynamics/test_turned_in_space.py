"""A case turned and moved in space gives the same result to rounding, whatever of it has a direction; so do its mirror
image and another numbering of its mesh."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest
from free_scene import EachStep

from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.schema import Case
from billow.parts.bodies.bodies import Bodies
from billow.parts.driven_nodes import DrivenNodes
from billow.parts.gas.corpuscular.inflow import injectors
from billow.parts.gas.gas_model import Bag
from billow.solver.model import Model
from billow.solver.run import Schedule, run

READY_MADE = {
    "diameter": 0.4, "element_size": 0.035, "initial_gap": 0.01, "mouth_radius": 0.05,
    "vents": {"count": 1, "distance": 0.12}, "straps": {"count": 0},
}  # fmt: skip
OBSTACLES = [
    {"shape": "plate", "height": -0.012, "normal": [0.03, -0.04, 1.0]},
    {
        "shape": "super-ellipsoid", "name": "head", "radii": [0.06, 0.05, 0.04], "degree": 3.0, "clearance": 0.017,
        "offset": [0.03, 0.02], "angle_about_x": 25.0, "mass": 0.2, "locked": False, "velocity": [-4.0, 2.0, -20.0],
        "spin": [30.0, -20.0, 50.0],
    },
    {"shape": "super-ellipsoid", "name": "block", "radii": 0.05, "clearance": 0.011, "offset": [-0.081, 0.01]},
]  # fmt: skip
LAWS = {"linear": {}, "curves": {"law": "curves-shear", "library": "nylon66-470dtex"}}


def turn(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrix of a unit quaternion (w, x, y, z)."""
    w, v = quaternion[0], quaternion[1:]
    across = -np.cross(np.eye(3), v).T
    return np.eye(3) + 2.0 * w * across + 2.0 * across @ across


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Quaternion of the turn q followed by the turn p."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


@dataclass(frozen=True)
class View:
    """Where a case stands: turned by a quaternion and moved by `away` [m]; before, mirrored in y and renumbered."""

    quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    away: tuple[float, ...] = (0.0, 0.0, 0.0)
    mirrored: bool = False
    renumbered: bool = False

    @property
    def hand(self) -> float:
        """-1 for a mirror image: the sign of angles in the plane of the bag."""
        return -1.0 if self.mirrored else 1.0

    @property
    def matrix(self) -> np.ndarray:
        return turn(np.array(self.quaternion)) * [1.0, self.hand, 1.0]

    def spin(self, vector) -> np.ndarray:
        """An axial vector seen from here: spin, angular momentum."""
        return self.hand * self.matrix @ vector

    def attitude(self, quaternion: np.ndarray) -> np.ndarray:
        return product(np.array(self.quaternion), quaternion * [1.0, self.hand, 1.0, self.hand])

    def order(self, count: int, first: int = -1) -> np.ndarray:
        """New place of each of `count` things; `first`: one whose place stays the lowest."""
        order = np.random.default_rng(3).permutation(count) if self.renumbered else np.arange(count)
        if self.renumbered and first >= 0:
            other = np.flatnonzero(order == 0)[0]
            order[other], order[first] = order[first], 0
        return order


HERE = View()
VIEWS = {
    "turned and moved": View((0.8, 0.2, -0.4, 0.4), (0.7, -1.1, 0.4)),
    "mirrored": View(mirrored=True),
    "renumbered": View(renumbered=True),
}


def write_mesh(path, points, triangles, part) -> str:
    lines = [
        "# vtk DataFile Version 3.0",
        "a bag",
        "ASCII",
        "DATASET UNSTRUCTURED_GRID",
        f"POINTS {len(points)} double",
    ]
    lines += [" ".join(map(repr, map(float, point))) for point in points]
    lines += [f"CELLS {len(triangles)} {4 * len(triangles)}", *(f"3 {a} {b} {c}" for a, b, c in triangles)]
    lines += [f"CELL_TYPES {len(triangles)}", *["5"] * len(triangles), f"CELL_DATA {len(triangles)}"]
    lines += ["SCALARS part int 1", "LOOKUP_TABLE default", *map(str, part)]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def new_nodes(view: View) -> np.ndarray:
    """New number of each node of the bag."""
    shape = build_shape(Case.from_dict({"bag": READY_MADE}).bag)
    mouth = shape.surface.triangles[shape.surface.triangles_of("mouth")]
    return view.order(len(shape.positions), int(mouth.min()))


def case_in_space(folder, view: View, **tables) -> Case:
    """A bag drawn as a mesh, and everything that a case gives a direction."""
    shape = build_shape(Case.from_dict({"bag": READY_MADE}).bag)
    nodes, cells = new_nodes(view), np.argsort(view.order(shape.surface.triangle_count))
    points = np.empty_like(shape.positions)
    points[nodes] = shape.positions @ view.matrix.T + view.away
    triangles, flat = nodes[shape.surface.triangles][cells], shape.reference[cells] * [1.0, view.hand]
    if view.mirrored:
        triangles, flat = triangles[:, [0, 2, 1]], flat[:, [0, 2, 1]]
    part, mouth = shape.surface.part[cells], shape.surface.triangles[shape.surface.triangles_of("mouth")]
    above = [int(np.linalg.norm(shape.positions - place, axis=1).argmin()) for place in ([0, -0.1, 1], [0.04, -0.1, 1])]
    straps = nodes[np.column_stack([above, mouth[:2, 0]])].tolist()
    pieces = np.pad(flat.reshape(-1, 2), ((0, 0), (0, 1)))
    folder.mkdir()
    bag = {
        "shape": "mesh",
        "start": write_mesh(folder / "start.vtk", points, triangles, part),
        "reference": write_mesh(folder / "flat.vtk", pieces, np.arange(len(pieces)).reshape(-1, 3), part),
        "parts": [
            {"name": "front", "number": 0, "warp_angle": 20.0 * view.hand},
            {"name": "rear", "number": 1, "warp_angle": -35.0 * view.hand, "seen_from": "inside"},
            {"name": "mouth", "number": 2, "kind": "mouth"},
            {"name": "vent_1", "number": 3, "kind": "vent"},
        ],
        "straps": [{"nodes": straps, "width": 0.05}],
    }
    jets = {"count": 8, "azimuth": 11.0 * view.hand, "spin": 300.0 * view.hand}
    run_table = {"gravity": (view.matrix @ [3.0, -40.0, 60.0]).tolist()}
    return Case.from_dict({"bag": bag, "inflator": {"jets": jets}, "obstacles": [], "run": run_table, **tables})


def model_in_space(folder, view: View, law: str) -> Model:
    """The model of that case, with obstacles of every shape, and a mouth that is driven: it tips and rises."""
    fabric = {"permeability": 0.05}
    model, bodies = build_model(case_in_space(folder, view, fabric=fabric | LAWS[law])), []
    for body in build_model(Case.from_dict({"bag": READY_MADE, "obstacles": OBSTACLES})).bodies.bodies:
        start = dataclasses.replace(
            body.start,
            centre=view.matrix @ body.start.centre + view.away,
            quaternion=view.attitude(body.start.quaternion),
            velocity=view.matrix @ body.start.velocity,
            angular_momentum=view.spin(body.start.angular_momentum),
        )
        bodies.append(dataclasses.replace(body, start=start))
    held = np.flatnonzero(model.fixed)
    middle = view.matrix @ [0.01, 0.02, 0.0] + view.away

    def path(time):
        half = view.spin([3.0 * time, 4.0 * time, 0.0])
        tipped = turn(np.array([np.sqrt(1.0 - half @ half), *half]))
        return (model.start[held] - middle) @ tipped.T + middle + view.matrix @ [0.2 * time, 0.0, -0.3 * time]

    return dataclasses.replace(
        model,
        bodies=Bodies(tuple(bodies), model.bodies.area, model.gravity),
        driven=DrivenNodes(held, model.mass[held], path),
    )


@pytest.mark.parametrize(("law", "name"), [("linear", name) for name in VIEWS] + [("curves", "turned and moved")])
def test_a_case_turned_and_moved_in_space_gives_the_same_result_to_rounding(law, name, tmp_path):
    """Jets that spin, straps, a vent, leakage, warp, gravity, driven nodes, obstacles of each shape that touch, turn,
    travel and meet. Rounding grows where kinks decide: three times as much is allowed as comes of a start that is off
    by one bit. Layers in contact are solved to a tolerance, in the order of their numbers: tests/contact."""
    view, schedule = VIEWS[name], Schedule(0.002, 1, 1)
    here, there = model_in_space(tmp_path / "a", HERE, law), model_in_space(tmp_path / "b", view, law)
    acted = set()

    def look(model, state):
        acted.update(name for name, energy in state.ledger.energies.items() if energy)
        acted.update(["obstacles that meet"] if state.bodies.meeting.force.any() else [])

    first, second = run(here, schedule, EachStep(look)), run(there, schedule)
    bit = 2.2e-16 * np.random.default_rng(0).choice([-1.0, 1.0], here.start.shape)
    off = run(dataclasses.replace(here, start=here.start + bit), schedule)
    spread = max(3.0 * np.abs(off.positions - first.positions).max(), 1e-13)
    assert spread < 1e-9
    moved = np.abs(first.positions - here.start).max()
    assert moved > 0.01
    assert first.step == second.step
    expected = first.positions @ view.matrix.T + view.away
    assert np.abs(expected - second.positions[new_nodes(view)]).max() < spread
    assert "obstacles that meet" in acted
    assert acted >= {"strain", "strap", "contact", "friction", "gas_work", "gravity_work", "drive_work"}
    largest = first.ledger.largest_energy
    for account, energy in first.ledger.energies.items():
        allowed = max(3.0 * abs(off.ledger[account] - energy), 1e-12 * largest)
        assert second.ledger[account] == pytest.approx(energy, abs=allowed)
    totals = first.gas.totals
    assert totals.jet_impulse_out > 0.0
    assert totals.vented_by["vent_1"] > 0.0
    assert totals.leaked > 0.0
    assert second.gas.totals.pressure == pytest.approx(totals.pressure, rel=1e-12)
    for before, after, beside in zip(first.bodies.motion, second.bodies.motion, off.bodies.motion, strict=True):
        for field, turned, least in (
            ("centre", view.matrix @ before.centre + view.away, 1e-13),
            ("velocity", view.matrix @ before.velocity, 1e-10),
            ("angular_momentum", view.spin(before.angular_momentum), 1e-12),
        ):
            allowed = max(3.0 * np.abs(getattr(beside, field) - getattr(before, field)).max(), least)
            assert getattr(after, field) == pytest.approx(turned, abs=allowed)


def test_particles_blow_out_of_the_same_places_of_the_mouth(tmp_path):
    """Random numbers are drawn along the axes of space, so that a turned run of particles differs as another seed does;
    holes and directions are those of the mouth."""
    view, found = VIEWS["turned and moved"], []
    for k, one in enumerate((HERE, view)):
        case = case_in_space(tmp_path / str(k), one, gas={"model": "corpuscular", "particles": 1000})
        model = build_model(case)
        particles = model.gas.model
        gas = particles.start(Bag(model.surface, model.start, np.zeros_like(model.start)))
        (injector,) = injectors(particles, particles.kinds(gas), model.start)
        found.append(injector.nozzles)
    here, there = found
    assert there.direction == pytest.approx(here.direction @ view.matrix.T, abs=1e-14)
    assert there.offset == pytest.approx(here.offset @ view.matrix.T, abs=1e-15)
