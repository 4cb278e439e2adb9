"""`billow paper`: the tables and figures of the ROM paper, from our own studies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from billow.base.errors import InputError
from billow.cli.endings import CONTINUES, interruptible
from billow.cli.options import Memory, make_console, memory_bytes, steps

NO_REPORT = InputError.declare(
    "E-CLI-008",
    "the report cannot be made",
    where="billow paper",
    cause="no study was named, a component other than x, y or z, or a case for the paper's recipe that has no study",
    remedy="billow paper --locked STUDY --out FOLDER; --paper-recipe z adds the paper's networks; --tubes RUN "
    "--tubes RUN, --gas RUN --gas RUN",
)


def paper(
    out: Annotated[Path, typer.Option(help="Folder of the report; the same command continues.")],
    locked: Annotated[Path | None, typer.Option(metavar="STUDY", help="Study of test case 1, locked obstacle.")] = None,
    free: Annotated[Path | None, typer.Option(metavar="STUDY", help="Study of test case 2, free obstacle.")] = None,
    paper_recipe: Annotated[
        str | None,
        typer.Option(metavar="COMPONENT", help="Also train the paper's own networks for x, y or z; takes hours."),
    ] = None,
    paper_recipe_case: Annotated[str, typer.Option(help="The case to train them on: locked or free.")] = "locked",
    paper_recipe_epochs: Annotated[int, typer.Option(min=1, help="Epochs of the paper's networks.")] = 15_000,
    jets: Annotated[
        tuple[Path, Path] | None,
        typer.Option(metavar="STUDY STUDY", help="Two studies of equal designs: uniform pressure, particles."),
    ] = None,
    jet_parameter: Annotated[
        str, typer.Option(help="Name of the jet direction among the parameters.")
    ] = "jet_direction",
    tubes: Annotated[
        list[Path] | None,
        typer.Option(metavar="RUN", help="LS-DYNA paper, 5.3: a run by one gas; for each again."),
    ] = None,
    gas: Annotated[
        list[Path] | None,
        typer.Option(metavar="RUN", help="LS-DYNA paper, 5.1, 5.2, 6.1: a run by one gas or mesh; for each again."),
    ] = None,
    kept: Annotated[Path | None, typer.Option(help="Folder for finished fits (default: OUT/kept).")] = None,
    memory: Memory = 4.0,
) -> None:
    """Tables 2-5 and Figures 4-12 of the ROM paper from our own runs, as a report and as files.

    A study may be incomplete: the report lists what is missing. An interrupted command continues where it stopped:
    every fit is kept, and the paper's networks are saved every 30 s.

    --tubes, once for each run, writes section 5.3 of the LS-DYNA paper from runs of examples/paper/window_tubes_*.toml
    by several gases; --gas likewise section 5.1, 5.2 or 6.1 from runs of one case by several gases, or with several
    values of gas.cell.
    """
    from billow.reproductions.gas_paper.gases import write_gases
    from billow.reproductions.gas_paper.window_tubes import write_tubes
    from billow.reproductions.rom_paper.available import available
    from billow.reproductions.rom_paper.case_results import case_results
    from billow.reproductions.rom_paper.document import write_document
    from billow.reproductions.rom_paper.jets import compare_jets
    from billow.reproductions.rom_paper.kept import Kept
    from billow.reproductions.rom_paper.published import CASES
    from billow.results.dataset import Dataset
    from billow.results.dataset_files import read_split
    from billow.results.ownership import owned
    from billow.results.result import Result
    from billow.rom.learn.train import Recipe, check_recipe, import_network
    from billow.study.study import Study

    folders = {"locked": locked, "free": free}
    if any(folders.values()):
        import_network()
        check_recipe(Recipe(epochs=paper_recipe_epochs, memory=memory_bytes(memory, "paper")))
    for wrong, why in (
        (
            jets is None and not tubes and not gas and not any(folders.values()),
            "none of --locked, --free and --jets names a study, and --tubes and --gas no runs",
        ),
        (paper_recipe not in (None, "x", "y", "z"), f"--paper-recipe {paper_recipe} is not one of x, y and z"),
        (paper_recipe and not folders.get(paper_recipe_case), f"--paper-recipe-case {paper_recipe_case} has no study"),
    ):
        if wrong:
            raise NO_REPORT(why=why)
    with interruptible(CONTINUES), owned(out, "tables.json"):
        console, results, missing = make_console(), [], []
        if tubes:
            console.print(f"LS-DYNA paper, 5.3: {write_tubes(out, [Result.open(run) for run in tubes])}")
        if gas:
            console.print(f"LS-DYNA paper, several gases: {write_gases(out, [Result.open(run) for run in gas])}")
        if jets is None and not any(folders.values()):
            return
        for case in CASES:
            folder = folders[case.name]
            if folder is None:
                missing.append(f"{case.heading}: no study was given.")
                continue
            dataset = Dataset.open(folder)
            train, test = read_split(folder)
            there = available(dataset, train, test, Study.open(folder).definition.sizes)
            for sentence in there.notes:
                console.print(f"{case.name}: {sentence}")
            component = paper_recipe if case.name == paper_recipe_case else None
            with steps(console) as progress:
                results.append(case_results(
                    case, dataset, there, Kept(kept or out / "kept"), recipe=component,
                    recipe_epochs=paper_recipe_epochs, memory=memory_bytes(memory, "paper"), progress=progress,
                ))  # fmt: skip
        if paper_recipe is None:
            missing.append("The paper's own recipe was not trained (--paper-recipe z).")
        compared = None
        if jets is None:
            missing.append("The effect of the jet direction in two gas models was not requested (--jets).")
        else:
            compared = compare_jets(*map(Dataset.open, jets), ("uniform pressure", "particles"), jet_parameter)
        console.print(f"report: {write_document(out, results, compared, missing)}")
