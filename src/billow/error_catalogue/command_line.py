"""Codes of the command line."""

from billow.base.errors import BillowError, InputError, ResourceError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-CLI-001": Entry(
        InputError,
        "A setting is no assignment.",
        "A value after --set without an equals sign.",
        "Write for example --set fabric.permeability=0.03.",
    ),
    "E-CLI-002": Entry(
        InputError,
        "The folder holds another demo.",
        "Its files were changed, or it was made with other options.",
        "Choose another folder with --out, or delete this one.",
    ),
    "E-CLI-003": Entry(
        InputError, "No case was given.", "A command without the path of a case.", "billow check CASE.toml"
    ),
    "E-CLI-004": Entry(
        InputError,
        "The file to be written exists already.",
        "A second prediction with the same --out.",
        "Choose another name with --out, or delete the file.",
    ),
    "E-CLI-005": Entry(
        ResourceError,
        "A file or folder cannot be used.",
        "No permission, a full disk, or a path that does not exist.",
        "Check path, permissions and free space.",
    ),
    "E-CLI-006": Entry(
        InputError,
        "A command was given a word it does not know.",
        "A misspelt name of a test, a law, a direction or a curve.",
        "Take one of those the message lists.",
    ),
    "E-CLI-007": Entry(
        InputError,
        "A number given to a command cannot be used.",
        "A unit that does not fit, or a value outside its range.",
        "Write the number with a unit, for example `--peak '35 deg'`.",
    ),
    "E-CLI-008": Entry(
        InputError,
        "The report of `billow paper` cannot be made.",
        "No study was named, a component other than x, y or z, or a case for the paper's recipe that has no study.",
        "Name a study: billow paper --locked STUDY --out FOLDER",
    ),
    "E-CLI-030": Entry(
        InputError,
        "There is no such verification case.",
        "A misspelt id.",
        "Choose one of the ids that the message lists.",
    ),
    "E-CLI-070": Entry(
        BillowError,
        "Billow itself failed.",
        "A mistake in Billow.",
        "Report it together with the file that the message names.",
    ),
}
