"""Every error and warning code: what it means, what usually causes it, and what helps.

docs/errors.md is made from this file. Codes are stable: a code keeps its meaning, and one that is no longer used is
never given to something else. A test compares the catalogue with the codes in the source.
"""

from __future__ import annotations

from dataclasses import dataclass

from billow.errors import BillowError, InputError, IntegrityError, NumericalStop, ResourceError


@dataclass(frozen=True)
class Entry:
    """kind: class of the error, None for a warning; meaning, cause, remedy: one sentence each."""

    kind: type[BillowError] | None
    meaning: str
    cause: str
    remedy: str


GROUPS = {
    "CASE": "The case file",
    "GEO": "Geometry",
    "GAS": "Gas",
    "NUM": "Runs that are stopped",
    "RES": "Results, datasets and interrupted runs",
    "STU": "Studies",
    "ROM": "Surrogates",
    "CLI": "The command line",
    "FAB": "Fabric",
    "MESH": "Mesh",
    "OBS": "Obstacles",
}
"""What the middle of a code stands for."""

CATALOGUE: dict[str, Entry] = {
    # --- the case file -----------------------------------------------------------------------------------------------
    "E-CASE-001": Entry(
        InputError,
        "The case file cannot be read.",
        "A misspelt path, or no permission.",
        "Check the path; `billow check --example` prints a case to start from.",
    ),
    "E-CASE-002": Entry(
        InputError,
        "The case file is not valid TOML.",
        "A missing quote or bracket, a key written twice, or a file of another kind.",
        "Correct the line that the message names; docs/case.md has an example.",
    ),
    "E-CASE-003": Entry(
        InputError,
        "A key of the case is not known.",
        "A misspelt key, or one in the wrong table.",
        "Take the suggested key, or one of those listed.",
    ),
    "E-CASE-004": Entry(
        InputError,
        "A key that has no default is missing.",
        "A curve with times and no values.",
        "Add the key; docs/case.md describes it.",
    ),
    "E-CASE-005": Entry(
        InputError,
        "A value of the case cannot be used.",
        "A number in another unit, outside its plausible range; a text where a number belongs; quantities that "
        "contradict each other.",
        'Write the unit, for example thickness = "0.3 mm"; docs/case.md gives units and ranges.',
    ),
    "E-CASE-006": Entry(
        InputError,
        "A dotted key does not lead to a setting of the case.",
        "A misspelt key after --set or among the keys of a study; an obstacle addressed by another name than its own.",
        "Take one of the names that the message lists.",
    ),
    # --- geometry ----------------------------------------------------------------------------------------------------
    "E-GEO-001": Entry(
        InputError,
        "The bag is not closed.",
        "A seam whose nodes are not merged, a hole, or a wall that divides the bag.",
        "Merge the nodes along the seam, or close the opening with a vent or mouth part.",
    ),
    "E-GEO-002": Entry(
        InputError,
        "Neighbouring triangles are oriented in opposite senses.",
        "A triangle whose nodes run the other way round.",
        "Reverse the node order of the flipped triangles.",
    ),
    "E-GEO-003": Entry(
        InputError,
        "All normals point inwards.",
        "A mesh whose triangles all run clockwise seen from outside.",
        "Reverse the node order of every triangle.",
    ),
    "E-GEO-004": Entry(
        InputError,
        "A triangle of the flat reference shape has no area.",
        "Two of its reference corners coincide, or all three lie on a line.",
        "Correct the reference coordinates of its nodes.",
    ),
    "E-GEO-010": Entry(
        InputError,
        "A mouth, vent or strap does not fit into its panel.",
        "A length in another unit, or a vent so close to a rim that no elements fit between.",
        "Change the key that the message names, or reduce bag.element_size.",
    ),
    "E-GEO-011": Entry(
        InputError,
        "The mesh would be too large for memory.",
        "bag.element_size or bag.diameter in another unit.",
        "Raise bag.element_size.",
    ),
    "E-GEO-020": Entry(
        InputError,
        "An obstacle penetrates the bag at the start.",
        "A clearance that is too small for the start shape, or a plate above z = 0.",
        "Raise the clearance of the obstacle, or lower the height of the plate.",
    ),
    "E-GEO-021": Entry(
        InputError,
        "An obstacle lies inside the bag at the start.",
        "A small obstacle within a start shape that is high.",
        "Raise its clearance, or move it aside with offset.",
    ),
    # --- gas ---------------------------------------------------------------------------------------------------------
    "E-GAS-001": Entry(
        InputError,
        "A gas is not known.",
        "A misspelt formula, or a gas without data.",
        "Use one of the gases that the message lists.",
    ),
    # --- runs that are stopped ---------------------------------------------------------------------------------------
    "E-NUM-001": Entry(
        NumericalStop,
        "A position, a velocity or a state of the gas is no longer a finite number.",
        "A step too large for the smallest or stiffest element.",
        "Reduce run.dt_scale; look at the node that the message names, and at the warnings of the case.",
    ),
    "E-NUM-002": Entry(
        NumericalStop,
        "The gas left its temperature range, 150 to 3,000 K.",
        "Mass flow or temperature of the inflator in another unit.",
        "Check inflator.mass_flow and inflator.temperature.",
    ),
    "E-NUM-003": Entry(
        NumericalStop,
        "More than a fifth of the energy appeared from nowhere.",
        "A step too large for the stiffest part, or gas that fills a very soft bag within a few steps.",
        "Reduce run.dt_scale; check the moduli of the fabric.",
    ),
    "E-NUM-004": Entry(
        NumericalStop,
        "The stable step fell below a ten-thousandth of the first.",
        "Fabric stretched beyond all bounds.",
        "Check the moduli of the fabric and inflator.mass_flow.",
    ),
    "E-NUM-005": Entry(
        NumericalStop,
        "Fabric is stretched to three times its length; real fabric tears at 1.3.",
        "Too much gas, or fabric that is too soft or too thin.",
        "Check inflator.mass_flow, fabric.young_warp, fabric.young_weft and fabric.thickness.",
    ),
    "E-NUM-006": Entry(
        NumericalStop,
        "Fabric went deeper into an obstacle than half its smallest radius.",
        "The obstacle is too soft for the load.",
        "Raise the slope of the obstacle.",
    ),
    # --- results -----------------------------------------------------------------------------------------------------
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
    # --- studies -----------------------------------------------------------------------------------------------------
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
    # --- surrogates --------------------------------------------------------------------------------------------------
    "E-ROM-001": Entry(
        InputError,
        "The design does not fit the surrogate.",
        "A misspelt or missing parameter, or a value that is no number.",
        "Give one number for each parameter; without --set `billow predict` lists them.",
    ),
    "E-ROM-002": Entry(
        InputError,
        "A parameter lies outside the range that was trained.",
        "A value in another unit, or a question the surrogate cannot answer.",
        "Choose a value inside, train on a wider study, or insist with --extrapolate.",
    ),
    "E-ROM-003": Entry(
        InputError,
        "A time lies outside the times that were trained.",
        "Times in milliseconds, or beyond the end of the runs.",
        "Choose times inside, or train on longer runs.",
    ),
    "E-ROM-004": Entry(
        IntegrityError,
        "The surrogate file is damaged, cut short or no surrogate.",
        "A copy that was cut short, or a file of another program.",
        "Copy it again from where it came, or train it again: billow train FOLDER",
    ),
    "E-ROM-005": Entry(
        InputError,
        "The surrogate cannot be read.",
        "A misspelt path, or a file from a newer version of Billow.",
        "Check the path, or train one: billow train FOLDER",
    ),
    "E-ROM-006": Entry(
        ResourceError,
        "PyTorch is not installed.",
        "Training needs it; prediction does not.",
        "Install it with pip install torch.",
    ),
    "E-ROM-007": Entry(
        InputError,
        "There are too few runs for so many modes, or none at all.",
        "The study has not been run, or --modes exceeds the number of snapshots.",
        "Finish the study, or reduce --modes.",
    ),
    "E-ROM-008": Entry(
        InputError,
        "There is no such recipe.",
        "A misspelt name after --recipe.",
        'Use "shared" or "paper".',
    ),
    "E-ROM-009": Entry(
        InputError,
        "A run holds displacements that are not finite.",
        "A run folder that was written by another program.",
        "Delete the run and give the command of the study again, which makes what is missing.",
    ),
    "E-ROM-010": Entry(
        InputError,
        "A parameter or the time has no range to learn from.",
        "A dataset in which a parameter is the same everywhere, or with one recorded time.",
        "Vary the parameter, or leave it out.",
    ),
    "E-ROM-011": Entry(
        InputError,
        "The surrogate has no spread.",
        "It was trained with the recipe paper, which has one network for each coefficient.",
        'Train with the recipe "shared".',
    ),
    "E-ROM-012": Entry(
        InputError,
        "The surrogate was not trained on this dataset.",
        "A surrogate of another study, or of an earlier state of this one.",
        "Evaluate it with its own dataset, or train one on this: billow train FOLDER",
    ),
    "E-ROM-013": Entry(
        NumericalStop,
        "The reduced basis is not orthonormal.",
        "Displacements beyond all bounds, or a faulty library for linear algebra.",
        "Look at the largest displacements of the runs.",
    ),
    "E-ROM-014": Entry(
        NumericalStop,
        "Training diverged.",
        "Outliers among the runs.",
        "Train with another --seed; look at the runs for outliers.",
    ),
    "E-ROM-015": Entry(
        InputError,
        "There are no unseen runs to compare a surrogate with.",
        "The test runs of the study are not made yet, or failed.",
        "Finish the study: billow study STUDY.toml --out FOLDER",
    ),
    # --- the command line --------------------------------------------------------------------------------------------
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
    # --- warnings ----------------------------------------------------------------------------------------------------
    "W-FAB-001": Entry(
        None,
        "Sound travels at a speed that no woven fabric has.",
        "A modulus or the density in another unit.",
        'Write units, for example young_warp = "0.4 GPa".',
    ),
    "W-FAB-002": Entry(
        None,
        "The fabric is too light or too heavy.",
        "Density or thickness in another unit.",
        'Write units, for example thickness = "0.3 mm".',
    ),
    "W-FAB-003": Entry(
        None,
        "The moduli of the fabric do not go together.",
        "A power of ten lost in one of them.",
        "Check fabric.young_warp, fabric.young_weft and fabric.shear.",
    ),
    "W-GAS-001": Entry(
        None,
        "Less than half of the gas comes before the run ends.",
        "Times of the curve in milliseconds, or a run that is too short.",
        "Write times with units, or raise run.end_time.",
    ),
    "W-GAS-002": Entry(
        None,
        "All gas comes within a fiftieth of the run.",
        "Times of the curve in another unit.",
        'Write times with units, for example "50 ms".',
    ),
    "W-GAS-003": Entry(
        None,
        "The gas would fill a small part of the bag, or many bags.",
        "Mass in grams, or a length in millimetres.",
        "Check inflator.mass_flow and bag.diameter.",
    ),
    "W-GAS-004": Entry(
        None,
        "Vents or fabric let out more gas than the inflator gives.",
        "A permeability or a vent in another unit.",
        "Reduce fabric.permeability or bag.vents.diameter.",
    ),
    "W-GAS-005": Entry(
        None,
        "The vents open at a pressure that no bag works at.",
        "A pressure in another unit.",
        'Write units, for example opening_pressure = "20 kPa".',
    ),
    "W-GAS-006": Entry(
        None,
        "The ring of jets is wider than the mouth the inflator is mounted in.",
        "A radius and a diameter exchanged.",
        "Reduce inflator.jets.ring_radius, or enlarge bag.mouth_radius.",
    ),
    "W-MESH-001": Entry(
        None,
        "The bag has fewer than ten elements across.",
        "An element size for a quick look.",
        "Use at most a twentieth of bag.diameter.",
    ),
    "W-MESH-002": Entry(
        None,
        "The fabric starts stretched.",
        "A start shape that is too high, or reference coordinates that belong to other nodes.",
        "Use a bag.initial_gap of a few millimetres.",
    ),
    "W-MESH-003": Entry(
        None,
        "A strap starts stretched.",
        "A strap shorter than the way from the retainer ring to its stitch line.",
        "Lengthen bag.straps.length.",
    ),
    "W-OBS-001": Entry(
        None,
        "An obstacle is too far away for the bag to reach it.",
        "A clearance in another unit.",
        "Reduce the clearance, or remove the obstacle.",
    ),
    "W-OBS-002": Entry(
        None,
        "A free obstacle is lighter than foam or heavier than lead.",
        "Mass or radii in another unit.",
        'Write units, for example mass = "4500 g".',
    ),
    "W-OBS-003": Entry(
        None,
        "An obstacle is softer than the bag.",
        "The slope in N/mm.",
        'Write units, for example slope = "100 N/mm".',
    ),
}
