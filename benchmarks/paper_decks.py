"""The LS-DYNA paper's examples as decks of *AIRBAG_HYBRID and *AIRBAG_PARTICLE: written, imported, and run beside the
cases they are of.

    python benchmarks/paper_decks.py square_two_stage flat_driver --coarse --end 5

With uniform pressure both runs must have the same bits; with particles the mean of three seeds of the deck must lie
within the range of three seeds of the case.
"""

from __future__ import annotations

import argparse
import tempfile
import tomllib
from pathlib import Path

import numpy as np

from billow.case.schema import Case
from billow.decks.export_deck import export_deck
from billow.decks.import_deck import import_deck
from billow.run.simulate import simulate

PAPER = Path(__file__).resolve().parents[1] / "examples" / "paper"
COARSE = {"square_two_stage": 0.06, "square_spinning_jet": 0.05, "folded_tube": 0.02, "flat_driver": 0.05,
          "folded_driver": 0.03, "window_tubes": 0.018}  # fmt: skip
"""Example -> element size [m] of a quick look."""
SMOKE = {"molar_mass": 0.028, "a": 29.0, "b": 1e-3, "c": -1e-7}
SEEDS = (1, 2, 3)
CURVES = ("volume [m^3]", "pressure [Pa]")


def sayable(example: str, gas: str, coarse: bool) -> Case:
    """An example as far as a deck can say it: a gas of one species whose heat is a polynomial, which fills the bag at
    the start too, no spin, seams as thick as the rest, and the plate alone: a ball would become triangles."""
    tables = tomllib.loads((PAPER / f"{example}_{'particles' if gas == 'corpuscular' else 'up'}.toml").read_text())
    given = tables["inflator"] if isinstance(tables["inflator"], list) else [tables["inflator"]]
    stages = []
    for k, one in enumerate(given, 1):
        jets = {**one["jets"], "spin": 0.0} if gas == "corpuscular" else {"count": 0}
        stages.append({**one, "name": f"gas_{k}", "gas": {f"gas_{k}": 1.0}, "jets": jets})
    settings = {"seam": {"layers": 1.0}, **({"element_size": COARSE[example]} if coarse else {})}
    species = {one["name"]: SMOKE for one in stages}
    plates = [one for one in tables.get("obstacles", []) if one["shape"] == "plate"]
    return Case.from_dict({
        **tables, "bag": {**tables["bag"], **settings}, "inflator": stages, "obstacles": plates,
        "gas": {**tables["gas"], "species": species, "initial": {"gas": {"gas_1": 1.0}}},
        "fabric": {**tables.get("fabric", {}), "self_contact": True},
    })  # fmt: skip


def curves(case: Case, folder: Path, seed: int) -> list[np.ndarray]:
    """Histories of a run; without particles a seed is a shorter step."""
    settings = {"run.dt_scale": case.run.dt_scale * (1.15 - 0.15 * seed)}
    histories = simulate(
        case.vary({"gas.seed": seed} if case.gas.model == "corpuscular" else settings), folder
    ).histories
    return [np.asarray(histories[name]) for name in CURVES]


def compare(example: str, gas: str, coarse: bool, end: float | None, particles: int | None) -> bool:
    """Print how far deck and case lie apart; whether that is as it must be."""
    made, same_bits = sayable(example, gas, coarse), gas != "corpuscular" and example != "window_tubes"
    settings = {"run.end_time": end, "gas.particles": particles}
    # A deck has no length of steps, and none of the guards of a case.
    settings |= {"run.dt_scale": made.run.dt_scale, "run.guard_crossings": made.run.guard_crossings}
    settings = {key: value for key, value in settings.items() if value is not None}
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        notes = export_deck(made, place / "bag.k")
        report = import_deck(place / "bag.k", place / "case")
        runs = []
        for name, case in (("native", made), ("deck", Case.load(place / "case" / "case.toml"))):
            seeds = SEEDS[:1] if same_bits else SEEDS
            runs.append([curves(case.vary(settings), place / f"{name}{seed}", seed) for seed in seeds])
    good = not report.of("refused")
    for k, name in enumerate(CURVES):
        native, deck = (np.array([one[k] for one in side]) for side in runs)
        scale = np.abs(native).max()
        off = np.abs(native.mean(axis=0) - deck.mean(axis=0)).max() / scale
        spread = 0.0 if same_bits else np.ptp(native, axis=0).max() / scale
        good = good and off <= spread
        print(f"{example:20} {gas:17} {name:14} apart {off:.3e}  range of seeds {spread:.3e}", flush=True)
    for note in notes:
        print(f"  {note}")
    return good


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("examples", nargs="*", default=list(COARSE), metavar="EXAMPLE", help=", ".join(COARSE))
    parser.add_argument("--coarse", action="store_true", help="large elements; otherwise those of the paper")
    parser.add_argument("--end", type=float, help="end of the runs [ms]; otherwise that of the paper")
    parser.add_argument("--particles", type=int, help="otherwise those of the paper")
    arguments = parser.parse_args()
    end = arguments.end and 1e-3 * arguments.end
    good = [
        compare(example, gas, arguments.coarse, end, arguments.particles)
        for example in arguments.examples
        for gas in ("uniform-pressure", "corpuscular")
    ]
    print("as it must be" if all(good) else "NOT as it must be")
    raise SystemExit(not all(good))


if __name__ == "__main__":
    main()
