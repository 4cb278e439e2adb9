"""Codes of studies."""

from billow.base.errors import BillowError, InputError, IntegrityError, NumericalStop, ResourceError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-STU-001": Entry(
        InputError, "The study file cannot be read.", "A misspelt path, or no permission.", "Check the path."
    ),
    "E-STU-002": Entry(
        InputError,
        "The study file is not valid TOML.",
        "A missing quote or bracket, or a file of another kind.",
        "Correct the line that the message names.",
    ),
    "E-STU-003": Entry(
        InputError, "A key of the study file is not known.", "A misspelt key.", "Take one of the keys listed."
    ),
    "E-STU-004": Entry(
        InputError,
        "A value of the study file cannot be used.",
        "A range that is empty, a name given twice, or a value of another kind.",
        "Correct the value; `billow demo` writes an example, study.toml.",
    ),
    "E-STU-005": Entry(
        InputError,
        "A key of the study file is missing.",
        "It has no default.",
        "Add the key.",
    ),
    "E-STU-006": Entry(
        InputError,
        "The case file of a study does not exist.",
        "A path that is not relative to the study file.",
        "Give its path relative to the study file.",
    ),
    "E-STU-007": Entry(
        InputError,
        "The case does not accept a design of the study.",
        "A misspelt key, or a range that goes beyond what is plausible.",
        "Correct the parameter that the message names; docs/case.md gives keys and ranges.",
    ),
    "E-STU-008": Entry(
        InputError,
        "The folder holds something else than this study.",
        "The study or its case was changed after the folder was made.",
        "Choose another folder, or delete this one.",
    ),
    "E-STU-009": Entry(
        InputError,
        "The folder holds no study.",
        "A misspelt path.",
        "Make it: billow study STUDY.toml --out FOLDER",
    ),
    "E-STU-010": Entry(
        IntegrityError,
        "A run on disk is not the run of its design.",
        "study.toml, case.toml or design.csv in the study folder was changed.",
        "Restore the file, or move the run away to make it again.",
    ),
    "E-STU-011": Entry(
        IntegrityError,
        "The runs of a study differ in mesh or times.",
        "A parameter that changes the mesh or the recorded times is varied.",
        "Vary only parameters that change neither; start anew in another folder.",
    ),
    "E-STU-012": Entry(
        ResourceError,
        "The disk is full.",
        "Results need more room than there is; `billow check` says how much a run needs.",
        "Free space and give the same command again: finished runs are kept.",
    ),
    "E-STU-013": Entry(
        InputError,
        "Another process runs this study.",
        "The command was given twice.",
        "Wait for it, or stop it; the study can then be continued.",
    ),
    "E-STU-014": Entry(
        NumericalStop,
        "A run of a study ended early and its solver did not say why.",
        "A solver other than Billow's own.",
        "Look at the last frames it left in failed/.",
    ),
    "E-STU-015": Entry(
        InputError,
        "The scheduler does not answer.",
        "A misspelt address, or a cluster that is not running.",
        "Give an address such as tcp://host:8786, as `dask scheduler` prints it.",
    ),
    "E-STU-016": Entry(
        BillowError,
        "A simulation of a study ended with an error that should not be.",
        "A mistake in Billow.",
        "Make the run by itself, and report it.",
    ),
    "E-STU-017": Entry(
        ResourceError,
        "The connection to the scheduler was lost.",
        "The scheduler ended, or the network failed.",
        "Give the same command again: finished runs are kept.",
    ),
    "E-STU-018": Entry(
        ResourceError,
        "A worker cannot make runs.",
        "It cannot see the study folder, or has no Billow or another version of it.",
        "Put the study on a shared file system; install the same version everywhere.",
    ),
    "E-STU-019": Entry(
        ResourceError,
        "The worker process of a run died in every attempt.",
        "Too little memory, a kill from outside, or a crash in compiled code.",
        "Check the machine's memory, then repeat with --retry-failed.",
    ),
    "E-STU-020": Entry(
        IntegrityError,
        "The files of a study contradict each other.",
        "design.csv or split.toml was changed.",
        "Restore both, or make the study again in a new folder.",
    ),
    "E-STU-021": Entry(
        InputError,
        "The number of workers cannot be used.",
        "Less than one worker, or workers together with a scheduler.",
        "Give --workers or --scheduler, or neither.",
    ),
    "E-STU-022": Entry(
        ResourceError,
        "Worker processes could not be started.",
        "A script that runs a study without the guard of its main module.",
        'Call run() under `if __name__ == "__main__":`, or with workers=1.',
    ),
    "E-STU-023": Entry(
        ResourceError,
        "The study folder cannot be written.",
        "No permission, a read-only disk, or a file where a folder was expected.",
        "Check path and permissions, or choose another folder with --out.",
    ),
    "E-STU-024": Entry(
        InputError,
        "The table of added designs cannot be used.",
        "A misspelt path in added_designs, columns that are not the parameters, or a value outside its range.",
        "Let `billow suggest` write it, or write one column for each parameter, headed name [unit].",
    ),
    "E-STU-025": Entry(
        InputError,
        "The training runs of a study cannot grow to this number.",
        "A train that is no multiple of the number of training runs there are.",
        "Set train to a multiple, or list more designs in added_designs.",
    ),
    "E-STU-026": Entry(
        InputError,
        "The table of runs to import cannot be used.",
        "No runs.csv, a column that is not headed name [unit], or a value that is no number or the same everywhere.",
        "Write a column run, one column name [unit] for each parameter, and one row for each run.",
    ),
    "E-STU-027": Entry(
        InputError,
        "A run to import cannot be read.",
        "A file that is missing, cut short or of another kind, or positions that are not finite.",
        "Export the run again.",
    ),
    "E-STU-028": Entry(
        InputError,
        "A run to import does not fit the others.",
        "Another mesh, nodes in another order, another start shape, or other times.",
        "Give all runs one mesh and the same times.",
    ),
    "E-STU-029": Entry(
        InputError,
        "Mesh or times of the runs to import are not known.",
        "NumPy or CSV frames without triangles.csv or times.csv beside them.",
        "Put both beside the runs, or into every .npz.",
    ),
}
