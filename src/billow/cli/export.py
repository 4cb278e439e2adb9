"""`billow export`: a surrogate for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    surrogate_file: Annotated[Path, typer.Argument(help="Surrogate file.")],
    out: Annotated[Path, typer.Option(help="ONNX file, such as surrogate.onnx.")],
) -> None:
    """Write a surrogate as ONNX: a design in, the displacement of every node at every trained time out.

    Needs the packages onnx and onnxruntime; the file is checked against NumPy before it is written.
    """
    from billow.rom.surrogate.onnx_export import export_onnx
    from billow.rom.surrogate.surrogate import Surrogate

    surrogate = Surrogate.load(surrogate_file)
    difference = export_onnx(surrogate, out)
    print(f"{out}: answers differ from NumPy's by at most {difference:.1e} of the largest displacement")
