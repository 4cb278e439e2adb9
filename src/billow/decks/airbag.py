"""Which airbag of a deck is imported, and what reads it."""

from __future__ import annotations

from collections.abc import Callable

from billow.base.errors import InputError
from billow.decks.airbag_ale import advanced, ale
from billow.decks.airbag_gas import Airbag
from billow.decks.airbag_particle import particle
from billow.decks.airbag_sealed import adiabatic, pressure_volume
from billow.decks.airbag_uniform import hybrid, simple, wang_nefske
from billow.decks.block import Block
from billow.decks.context import Context
from billow.decks.fields import known

NO_CHOICE = InputError.declare(
    "E-DCK-015",
    "the deck has {count} airbags of which none was chosen",
    where="{place}",
    why="they are {listed}; no *AIRBAG_INTERACTION joins them, or one is of a kind that is not read",
    cause="a model with several cushions",
    remedy="choose one by its number in this list: --airbag 1",
)
NOT_READ = InputError.declare(
    "E-DCK-016",
    "*{keyword} cannot be imported",
    where="{place}",
    cause="an airbag of a kind that Billow does not have",
    remedy="use *AIRBAG_HYBRID, _PARTICLE or _ALE; or take the mesh alone, with --base CASE.toml for the rest",
)

READ = (
    "AIRBAG_HYBRID", "AIRBAG_PARTICLE", "AIRBAG_WANG_NEFSKE", "AIRBAG_SIMPLE_AIRBAG_MODEL", "AIRBAG_ALE",
    "AIRBAG_ADVANCED_ALE", "AIRBAG_ADIABATIC_GAS_MODEL", "AIRBAG_SIMPLE_PRESSURE_VOLUME",
)  # fmt: skip
WHY_NOT = {
    "AIRBAG_LINEAR_FLUID": "it is filled with a liquid",
    "AIRBAG_FLUID_AND_GAS": "it is filled with a liquid",
    "AIRBAG_LOAD_CURVE": "pressure is given there, and no gas flows",
    "AIRBAG_HYBRID_CHEMKIN": "its gases are in a data base of its own",
    "AIRBAG_CPG": "its gas is a continuum of particles, with cards of its own",
}


def choose(blocks: list[Block], wanted: int | None) -> Block | None:
    """The airbag to import, None if the deck has none. Raises InputError E-DCK-015, -016."""
    bags = [b for b in blocks if (known(b.name) in READ or _why_not(b.name)) and "REFERENCE" not in b.name]
    bags = [b for b in bags if b.name not in ("AIRBAG_INTERACTION",)]
    if not bags:
        return None
    listed = "; ".join(f"{k}: *{b.name} at {b.place}" for k, b in enumerate(bags, 1))
    if wanted is None and len(bags) > 1:
        raise NO_CHOICE(count=len(bags), listed=listed, place=bags[0].place)
    if wanted is not None and not 1 <= wanted <= len(bags):
        raise NO_CHOICE(count=len(bags), place=bags[0].place, why=f"there is no {wanted}; {listed}")
    chosen = bags[(wanted or 1) - 1]
    why = _why_not(chosen.name)
    if why:
        raise NOT_READ(keyword=chosen.name, place=chosen.place, why=why)
    return chosen


def joined(blocks: list[Block]) -> list[Block]:
    """All airbags of a deck, if *AIRBAG_INTERACTION joins them and all are read; else none."""
    if not any(b.name == "AIRBAG_INTERACTION" for b in blocks):
        return []
    bags = [b for b in blocks if "REFERENCE" not in b.name and b.name != "AIRBAG_INTERACTION"]
    return bags if len(bags) > 1 and all(known(b.name) in READ for b in bags) else []


def _why_not(name: str) -> str | None:
    found = max((k for k in WHY_NOT if name == k or name.startswith(k + "_")), key=len, default=None)
    return WHY_NOT[found] if found else None


def put_airbag(context: Context, block: Block) -> Airbag:
    """The tables of the gas. Raises InputError for fields that cannot be used."""
    return READERS[known(block.name)](context, block)


READERS: dict[str, Callable[[Context, Block], Airbag]] = {
    "AIRBAG_HYBRID": hybrid,
    "AIRBAG_PARTICLE": particle,
    "AIRBAG_WANG_NEFSKE": wang_nefske,
    "AIRBAG_SIMPLE_AIRBAG_MODEL": simple,
    "AIRBAG_ALE": ale,
    "AIRBAG_ADVANCED_ALE": advanced,
    "AIRBAG_ADIABATIC_GAS_MODEL": adiabatic,
    "AIRBAG_SIMPLE_PRESSURE_VOLUME": pressure_volume,
}
