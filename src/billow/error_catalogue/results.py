"""Codes of results, datasets and interrupted runs."""

from billow.base.errors import InputError, IntegrityError, ResourceError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-RES-001": Entry(
        InputError, "There is no such run.", "A misspelt path.", "Give the folder that `billow run` wrote."
    ),
    "E-RES-002": Entry(
        IntegrityError,
        "The folder holds no finished run.",
        "It is another folder, or the .partial folder of a run that was interrupted.",
        "Give the folder of a finished run; go on with an interrupted one: billow resume RUN",
    ),
    "E-RES-003": Entry(
        IntegrityError,
        "run.json is damaged or was changed.",
        "A copy that was cut short, or an edit by hand.",
        "Copy the run again from its source, or run the case again.",
    ),
    "E-RES-004": Entry(
        IntegrityError,
        "A file of a run changed since the run was published.",
        "A copy that was cut short, a bad disk, or an edit by hand.",
        "Copy the run again from its source, or run the case again.",
    ),
    "E-RES-005": Entry(
        IntegrityError,
        "A file of a run is missing.",
        "It was deleted, or not copied.",
        "Copy the run again from its source, or run the case again.",
    ),
    "E-RES-006": Entry(
        IntegrityError,
        "The run was written in a format that is not known.",
        "It comes from a newer version of Billow.",
        "Use the version of Billow that the file names as billow_version.",
    ),
    "E-RES-007": Entry(
        IntegrityError,
        "The moving mesh cannot be read.",
        "A missing field, or a file that is damaged or no fabric.vtkhdf.",
        "Check the path and the name of the field; if the file is damaged, run the case again.",
    ),
    "E-RES-008": Entry(
        IntegrityError,
        "histories.csv cannot be read.",
        "An edit by hand or with a spreadsheet.",
        "Run the case again.",
    ),
    "E-RES-009": Entry(
        InputError,
        "The result folder exists already.",
        "A second run with the same --out.",
        "Choose another folder with --out, or delete this one.",
    ),
    "E-RES-010": Entry(
        InputError,
        "The dataset has no completed run.",
        "The study has not been run, or all its runs failed.",
        "Make its runs first: billow study STUDY.toml --out FOLDER",
    ),
    "E-RES-011": Entry(
        IntegrityError,
        "dataset.toml, design.csv or split.toml cannot be read, or they contradict each other.",
        "An edit by hand, or a copy that was cut short.",
        "Restore the file, or make the study again in a new folder.",
    ),
    "E-RES-012": Entry(
        IntegrityError,
        "A run has another mesh or other times than its dataset.",
        "A parameter that changes the mesh or the recorded times was varied.",
        "Vary only parameters that keep both; use one dataset for each mesh.",
    ),
    "E-RES-013": Entry(
        InputError,
        "A dataset has no such field.",
        "A misspelt name.",
        'Ask for "displacement" or "contact_force".',
    ),
    "E-RES-014": Entry(
        InputError,
        "A run is not available.",
        "It failed, is not made yet, or is no run of the dataset.",
        "Use runs listed in Dataset.train and Dataset.test.",
    ),
    "E-RES-015": Entry(
        IntegrityError,
        "The case of a run cannot be read.",
        "The run folder was written by another program.",
        "Copy the run again from its source, or run the case again.",
    ),
    "E-RES-020": Entry(
        ResourceError,
        "Results could not be written.",
        "A full disk, or a folder without permission to write.",
        "Free space and go on: billow resume RUN",
    ),
    "E-RES-021": Entry(
        InputError,
        "There is no interrupted run to resume.",
        "The run has finished, or the path is another than its --out.",
        "Give the --out folder of the interrupted run.",
    ),
    "E-RES-022": Entry(
        InputError,
        "An interrupted run is waiting where a new one was to begin.",
        "The same command was given again after an interruption.",
        "Go on with it: billow resume RUN",
    ),
    "E-RES-030": Entry(
        IntegrityError,
        "The journal of a run is damaged.",
        "A disk that was full or failed while the run went on.",
        "Run the case again from the start.",
    ),
    "E-RES-031": Entry(
        IntegrityError,
        "No checkpoint of a run can be used.",
        "It is damaged, of another version of Billow, or its case.toml was changed.",
        "Run the case again from the start.",
    ),
    "E-RES-032": Entry(
        IntegrityError,
        "There is no checkpoint to resume from.",
        "The run ended before its first checkpoint, 30 s after its start.",
        "Run the case again.",
    ),
    "E-RES-033": Entry(
        IntegrityError,
        "The case of an interrupted run cannot be used.",
        "Its case.toml was changed or damaged.",
        "Run the case again from the start.",
    ),
}
