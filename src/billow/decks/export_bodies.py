"""Obstacles of a case in a deck: rigid walls, and rigid parts of triangles, one for each body and each box."""

from __future__ import annotations

import numpy as np

from billow.case.obstacles.motion import unit_vector
from billow.case.obstacles.obstacles import Movable, Placed, Plate, SuperEllipsoid
from billow.case.schema import Case
from billow.decks.deck_text import DeckText
from billow.decks.tables import HELD
from billow.geometry.bag_shapes import BagShape
from billow.geometry.shapes.mesh import mass_properties
from billow.geometry.shapes.pose import rotation_matrix
from billow.geometry.shapes.triangulated import triangulated

ROUGH = 2
"""Fineness of triangulated obstacles: 320 triangles, if they are round."""
SHEET = 1e-3
"""Thickness [m] of the shells of a body that is full."""
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Terms of a tensor in the order of *PART_INERTIA."""
STEEL = 7800.0
"""Density [kg/m^3] of what does not move."""


def put_bodies(deck: DeckText, case: Case, shape: BagShape, notes: list[str]) -> int:
    """All obstacles; the number of the last part."""
    writer = _Bodies(deck, notes, len(shape.surface.part_names), shape.surface.triangle_count)
    for obstacle in case.obstacles:
        if isinstance(obstacle, Plate):
            writer.part += 1
            _wall(deck, obstacle, writer.part, notes)
        elif isinstance(obstacle, Movable):
            writer.body(obstacle)
        elif isinstance(obstacle, Placed):
            writer.boxes(obstacle)
    return writer.part


class _Bodies:
    """part, shell: the last numbers that were given away."""

    def __init__(self, deck: DeckText, notes: list[str], part: int, shell: int):
        self.deck, self.notes, self.part, self.shell = deck, notes, part, shell

    def shells(self, points: np.ndarray, triangles: np.ndarray) -> None:
        """Nodes at points [m] and the shells of the next part."""
        self.part += 1
        first = self.deck.node_block(points)
        self.deck.keyword("ELEMENT_SHELL")
        for a, b, c in (triangles + first + 1).tolist():
            self.shell += 1
            self.deck.card(self.shell, self.part, a, b, c, c)

    def part_of(self, title: str, keyword: str = "PART") -> None:
        self.deck.keyword(keyword)
        self.deck.text(title)
        self.deck.card(self.part, self.part, self.part, 0, 0, 0, 0, 0)

    def rigid(self, thickness: float, density: float, constraint: tuple[float, int, int]) -> None:
        """Section and material of the part."""
        deck, part = self.deck, self.part
        deck.keyword("SECTION_SHELL")
        deck.card(part, 2, 1.0, 2, 1.0, 0, 0, 1)
        deck.card(*[deck.of(thickness, "length")] * 4)
        deck.keyword("MAT_RIGID")
        deck.card(part, deck.of(density, "density"), deck.of(1e9, "pressure"), 0.3)
        deck.card(*constraint)
        deck.card(0.0)

    def boxes(self, obstacle: Placed) -> None:
        """What is made of boxes: a rigid part for each of them, which all stand or move alike."""
        deck, motion = self.deck, obstacle.motion
        carried, _, start = obstacle.build()
        if motion.kind == "guided" and len(carried) > 1:
            self.notes.append(f"obstacles.{obstacle.name}: left out; its boxes would move apart on their rails")
            return
        turn = rotation_matrix(start.quaternion)
        for k, one in enumerate(carried, 1):
            points, triangles = triangulated(one.shape, ROUGH)
            self.shells((points + one.centre) @ turn.T + start.centre, triangles)
            self.part_of(obstacle.name if len(carried) == 1 else f"{obstacle.name}_{k}")
            area, *_ = mass_properties(points, triangles, is_sheet=True)
            density = motion.mass / (area * SHEET) if motion.kind == "guided" else STEEL
            constraint = (1.0, 7, 7) if motion.kind == "none" else _constraint(obstacle, self.notes)
            self.rigid(SHEET, density, constraint)
            _motion(deck, obstacle, self.part)
        if len(carried) > 1:
            self.notes.append(f"obstacles.{obstacle.name}: {len(carried)} rigid parts, one for each of its boxes")

    def body(self, obstacle: Movable) -> None:
        """A sphere that is locked as a rigid wall, anything else as a rigid part of triangles."""
        deck, notes = self.deck, self.notes
        (carried,), rigid, start = obstacle.build()
        motion = obstacle.motion
        radii = getattr(carried.shape, "radii", np.zeros(3))
        is_ball = isinstance(obstacle, SuperEllipsoid) and obstacle.degree == 2.0 and np.ptp(radii) == 0.0
        if is_ball and obstacle.locked and motion.kind != "guided":
            self.part += 1
            moves = motion.kind != "none"
            deck.keyword("RIGIDWALL_GEOMETRIC_SPHERE_MOTION_ID" if moves else "RIGIDWALL_GEOMETRIC_SPHERE_ID")
            deck.text(f"{self.part + 1000:>20}{obstacle.name}")
            deck.card(0, 0, 0, 0.0)
            head = start.centre + np.array([0.0, 0.0, radii[2]])
            ends = [deck.of(v, "length") for v in (*start.centre, *head)]
            deck.card(*ends, obstacle.friction)
            deck.card(deck.of(float(radii[0]), "length"))
            if moves:
                _wall_motion(deck, motion, obstacle.name)
            return
        points, triangles = triangulated(carried.shape, ROUGH)
        turn = rotation_matrix(start.quaternion)
        points = (points + carried.centre) @ turn.T + start.centre
        self.shells(points, triangles)
        free = not obstacle.locked
        self.part_of(obstacle.name, "PART_INERTIA" if free else "PART")
        if free:
            tensor = turn @ np.diag(rigid.inertia) @ turn.T
            deck.card(*[deck.of(v, "length") for v in start.centre], deck.of(rigid.mass, "mass"), 0, 0)
            deck.card(*[deck.of(tensor[i, j], "inertia") for i, j in UPPER])
            speeds = [deck.of(v, "velocity") for v in obstacle.velocity]
            deck.card(*speeds, *[deck.of(w, "frequency") for w in obstacle.spin])
        area, *_ = mass_properties(points, triangles, is_sheet=True)
        thickness = getattr(obstacle, "thickness", SHEET)
        mass = motion.mass if motion.kind == "guided" else rigid.mass
        self.rigid(thickness, mass / (area * thickness), _constraint(obstacle, notes))
        if isinstance(obstacle, SuperEllipsoid):
            notes.append(f"obstacles.{obstacle.name}: a rigid shell of {len(triangles)} triangles")
        _motion(deck, obstacle, self.part)


def _wall(deck: DeckText, plate: Plate, part: int, notes: list[str]) -> None:
    """A plane; one that moves by its own card, or as a flat face without end."""
    motion, normal = plate.motion, unit_vector(plate.normal)
    tail = np.array([*plate.offset, plate.height])
    face = [deck.of(v, "length") for v in (*tail, *(tail + normal))] + [plate.friction]
    if motion.kind in ("travel", "speed"):
        across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        deck.keyword("RIGIDWALL_GEOMETRIC_FLAT_MOTION_ID")
        deck.text(f"{part + 1000:>20}{plate.name}")
        deck.card(0, 0, 0, 0.0)
        deck.card(*face)
        deck.card(*[deck.of(v, "length") for v in tail + across], 0.0, 0.0)
        _wall_motion(deck, motion, plate.name)
        return
    sliding = motion.kind == "guided"
    along = sliding and float(unit_vector(motion.direction) @ normal) > 1.0 - 1e-12 and motion.force == 0.0
    if sliding and not along:
        notes.append(f"obstacles.{plate.name}.motion: a guided plate is written only along its normal, without force")
    deck.keyword("RIGIDWALL_PLANAR_MOVING_ID" if along else "RIGIDWALL_PLANAR_ID")
    deck.text(f"{part + 1000:>20}{plate.name}")
    deck.card(0, 0, 0, 0.0, 0.0)
    deck.card(*face, 0.0)
    if along:
        deck.card(deck.of(motion.mass, "mass"), deck.of(motion.speed, "velocity"))


def _wall_motion(deck: DeckText, motion, name: str) -> None:
    """The card of motion of a geometric wall, and its curve."""
    # The curve comes after the wall: a card must follow its keyword.
    deck.card(deck.curves + 1, 1 if motion.kind == "travel" else 0, *unit_vector(motion.direction).tolist())
    deck.course(motion, name)


def _constraint(obstacle: Movable | Placed, notes: list[str]) -> tuple[float, int, int]:
    """CMO, CON1, CON2 of a rigid part."""
    if obstacle.motion.kind == "none":
        return (1.0, 7, 7) if obstacle.locked else (0.0, 0, 0)
    across = "".join(axis for axis, v in zip("xyz", obstacle.motion.direction, strict=True) if not v)
    if obstacle.motion.kind == "guided" and len(across) < 2:
        notes.append(f"obstacles.{obstacle.name}.motion: guided along no axis of a deck; it is free to move there")
        return 1.0, 0, 7
    return 1.0, next(code for code, held in HELD.items() if set(held) == set(across)), 7


def _motion(deck: DeckText, obstacle: Movable | Placed, part: int) -> None:
    """What moves a rigid part: a motion that is prescribed, or speed and force along its rail."""
    motion, direction = obstacle.motion, np.zeros(3)
    if motion.kind != "none":
        direction = unit_vector(motion.direction)
    if motion.kind == "guided" and motion.speed:
        deck.keyword("INITIAL_VELOCITY_RIGID_BODY")
        deck.card(part, *[deck.of(v, "velocity") for v in motion.speed * direction], 0.0, 0.0, 0.0)
    ways = [(axis, share) for axis, share in enumerate(direction.tolist(), 1) if share]
    if motion.kind in ("travel", "speed"):
        curve = deck.course(motion, obstacle.name)
        deck.keyword("BOUNDARY_PRESCRIBED_MOTION_RIGID")
        for axis, share in ways:
            deck.card(part, axis, 2 if motion.kind == "travel" else 0, curve, share)
    elif motion.kind == "guided" and motion.force != 0.0:
        force = motion.force
        time, values = ([0.0, 1.0], [force, force]) if isinstance(force, float) else (force.time, force.value)
        curve = deck.curve(time, values, "time", "force", f"{obstacle.name} force")
        deck.keyword("LOAD_RIGID_BODY")
        for axis, share in ways:
            deck.card(part, axis, curve, share)
