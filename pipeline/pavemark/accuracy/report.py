"""What a stage hands in."""

from __future__ import annotations

import attrs


@attrs.frozen(eq=False)
class Report:
    """Files of a report.

    Attributes
    ----------
    files : dict
        Bytes or text by file name.
    told : str
        What came of it, in a few lines.
    """

    files: dict[str, bytes | str]
    told: str
