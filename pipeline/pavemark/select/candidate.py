"""An image that may be kept, as far as a selection knows it."""

from __future__ import annotations

import attrs


@attrs.frozen
class Candidate:
    """An image that may be kept.

    Attributes
    ----------
    name : str
        Of the image in its dataset.
    loss : float
        Its point loss.
    plate, domain : str or None
        The real image it was painted on, and what was done to it; None where that is not known.
    """

    name: str
    loss: float
    plate: str | None = None
    domain: str | None = None
