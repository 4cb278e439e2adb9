"""Seams that tear, and covers that open along one."""

from __future__ import annotations

from billow.case.bag.quantities import Layers, Length, NodePairs, Offset
from billow.case.quantity import Name, Strict, curve, quantity


class TearStrength(Strict):
    """A tear seam: when it tears, and how stiff it is until then."""

    name: Name = "tear_seam"
    """Name in results."""
    strength: quantity("N/m", 0.0, 1e6) | curve("N/m", 0.0, 1e6, "loading_rate")
    """Force per length of seam at which it tears: a number, or a curve against the rate of loading, which is the mean
    since the stitch there went taut."""
    stiffness: quantity("N/m^2", 0.0, 1e10) = 0.0
    """Force per length of seam and opening; 0 for that of a row of elements of the bag's fabric."""


class PanelTearSeam(TearStrength):
    """A straight seam that joins front and rear panel until it tears; nodes of both panels near the line are tied."""

    begin: tuple[Offset, Offset]
    """Its beginning (x, y), relative to the middle of the bag."""
    end: tuple[Offset, Offset]
    """Its end."""


class MeshTearSeam(TearStrength):
    """A seam of tied nodes of the mesh."""

    nodes: NodePairs
    """Pairs of nodes, counted from 0, in their order along the seam."""


class Cover(TearStrength):
    """A cover of fabric over the bag: two flaps, held at their outer edges and joined by a tear seam along y."""

    name: Name = "cover"
    """Name of its fabric and of its seam in results."""
    place: tuple[Offset, Offset, Offset]
    """Its middle (x, y, z)."""
    length: Length
    """Distance of the edges that are held, along x."""
    width: Length
    """Length of the seam, along y."""
    element_size: quantity("m", 5e-4, 0.2) = 0.010
    """Approximate edge length of its triangles."""
    layers: Layers = 2.0
    """Layers of the bag's fabric."""
