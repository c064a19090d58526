"""A labelled image: what detectors learn from, and what they are judged by."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np

from pavemark.ground import Frame


@attrs.frozen(eq=False)
class Example:
    """An image and what is known of it.

    Attributes
    ----------
    name : str
        Unique in its dataset; what manifests and shards call it.
    image : Path
        The picture, 8-bit RGB; read when it is needed.
    frame : Frame
        Size and scale of the picture.
    points : ndarray (N, 2) float64
        Visible marking points, image coordinates, continuous, pixels.
    directions : ndarray (N, 2) float64, or None
        Unit vectors in image coordinates; None where the labels are points alone.
    l_shaped : ndarray (N,) bool, or None
        Whether a point is an L and not a T; None where the labels are points alone.
    slots : ndarray (M, 2) int64, or None
        Positions in `points` of p1 and p2 of each slot; None where the labels are points alone.
    groups : dict of str to str
        What images are sorted by: "plate" (the real image it was painted on), "domain" (effects that not every
        image has), "kind" (of its slots, or "original" where its plate's own markings were painted anew), "place",
        "scene", "side". What is not known is not there.
    known : bool
        Whether every marking point in the picture is labelled: not where its plate's own markings were painted anew.
    """

    name: str
    image: Path
    frame: Frame
    points: np.ndarray
    directions: np.ndarray | None
    l_shaped: np.ndarray | None
    slots: np.ndarray | None
    groups: dict[str, str] = attrs.field(factory=dict)
    known: bool = True
