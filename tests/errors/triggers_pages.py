"""What no page can show."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from billow.cli.page_files import check_page_name
from billow.pages.explorer import explorer_page
from billow.pages.viewer import Shown, viewer_page
from trust.small_surrogate import small_surrogate

TRIGGERS = {
    "E-PAG-001": lambda here: explorer_page(dataclasses.replace(small_surrogate(), forces=object()), None, Path("s")),
    "E-PAG-002": lambda here: check_page_name(Path("view.png")),
    "E-PAG-003": lambda here: viewer_page([Shown("test", None)], "Tests"),
}
