"""Tables as CSV; `billow.base.table_file` reads them."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable


def csv_text(rows: Iterable[Iterable]) -> str:
    """Rows as the text of a CSV file; Python floats with as many digits as it takes to read back the same bits."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
