"""The distribution of real parking slots, fitted once and shipped as assets/layout.json."""

from __future__ import annotations

from functools import lru_cache

import attrs

from pavemark import assets
from pavemark.records import from_json, within

_share = within(0.0, 1.0)


@attrs.frozen
class Family:
    """Real slots of one family. Tables are quantiles at equal steps of probability, from the least to the greatest.

    Attributes
    ----------
    rows : float
        Share of all rows.
    entrance : tuple of float
        Length of the entrance line in metres.
    angle : tuple of float
        Degrees from p1 → p2 to p1 → p4, anticlockwise; 90 is perpendicular to the entrance line.
    depth : float
        Metres along the separating line.
    across : float
        Share of the rows whose entrance line crosses the car's axis rather than runs beside it.
    turn, turn_across : tuple of float
        Degrees from the car's axis (or, for rows across, from its normal) to the entrance line, anticlockwise.
    clearance, clearance_across : tuple of float
        Metres from the car's box to the entrance line; negative where the car stands on the line or in the slot.
    count : tuple of float
        Share of rows of 1, 2, 3, … slots.
    """

    rows: float = attrs.field(validator=_share)
    entrance: tuple[float, ...] = attrs.field(validator=within(0.5, 12.0))
    angle: tuple[float, ...] = attrs.field(validator=within(15.0, 165.0))
    depth: float = attrs.field(validator=within(0.5, 12.0))
    across: float = attrs.field(validator=_share)
    turn: tuple[float, ...] = attrs.field(validator=within(-45.0, 45.0))
    turn_across: tuple[float, ...] = attrs.field(validator=within(-45.0, 45.0))
    clearance: tuple[float, ...] = attrs.field(validator=within(-10.0, 10.0))
    clearance_across: tuple[float, ...] = attrs.field(validator=within(-10.0, 10.0))
    count: tuple[float, ...] = attrs.field(validator=_share)


@attrs.frozen
class Fitted:
    """All families and what they share.

    Attributes
    ----------
    provenance : str
        From what, and how, the figures were taken.
    perpendicular, parallel, acute, obtuse : Family
        Slanted slots are acute or obtuse by their angle.
    variation : tuple of float
        Quantiles of a slot's entrance length over that of the slot before it.
    gap_rate : float
        Share of neighbouring slots that do not share a marking point.
    gap : tuple of float
        Quantiles of the metres between them.
    left : float
        Share of rows to the left of the car, of those beside it.
    both_sides : float
        Share of images with a row that also have one opposite.
    """

    provenance: str
    perpendicular: Family
    parallel: Family
    acute: Family
    obtuse: Family
    variation: tuple[float, ...] = attrs.field(validator=within(0.1, 10.0))
    gap_rate: float = attrs.field(validator=_share)
    gap: tuple[float, ...] = attrs.field(validator=within(0.0, 10.0))
    left: float = attrs.field(validator=_share)
    both_sides: float = attrs.field(validator=_share)


@lru_cache(maxsize=1)
def fitted() -> Fitted:
    """The shipped distribution."""
    return from_json(Fitted, assets.path("layout.json"))
