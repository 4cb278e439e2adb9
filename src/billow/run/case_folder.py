"""A case as a run or a study keeps it: complete in one folder, which can be moved."""

from __future__ import annotations

from pathlib import Path

from billow.base.input_file import LARGEST_DATA, read_bytes
from billow.geometry.mesh_file import UNREADABLE
from billow.results.atomic import write_atomically


def keep_case(case, folder: Path, header: str = ""):
    """Write `folder`/case.toml, and beside it a copy of every mesh file that the case names; returns the case that
    reads the copies. Paths in case.toml count from its folder; header: comments for its top.

    InputError E-GEO-030 if a file cannot be read; OSError if the folder cannot be written.
    """
    names = {}
    for key, path in case.files.items():
        names[key] = f"{key.replace('.', '_')}{path.suffix.lower()}"
        try:
            content = read_bytes(path, LARGEST_DATA)
        except OSError as error:
            raise UNREADABLE(name=path.name, path=str(path), why=error) from error
        write_atomically(folder / names[key], content)
    write_atomically(folder / "case.toml", header + case.with_files(names).to_toml())
    return case.with_files({key: str(folder / name) for key, name in names.items()})
