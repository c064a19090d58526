"""What is kept of the images judged: for each thing found its confidence and whether it is there, and how many are."""

from __future__ import annotations

import attrs
import numpy as np


@attrs.frozen(eq=False)
class Tally:
    """Things of one kind, points or slots, found in a number of images.

    Attributes
    ----------
    confidence : ndarray (N,) float64
        Of all that was found.
    hit : ndarray (N,) bool
        Whether it was matched with one that is there.
    image : ndarray (N,) int64
        In which of the images, ascending.
    truths : ndarray (I,) int64
        How many there are in each of the images.
    """

    confidence: np.ndarray
    hit: np.ndarray
    image: np.ndarray
    truths: np.ndarray

    def of(self, images: np.ndarray) -> Tally:
        """What was found in some of the images, given by their positions."""
        # What is found in an image lies together: of 300,000 images those of a plate are not looked for in all.
        first, end = (np.searchsorted(self.image, images, side) for side in ("left", "right"))
        count = end - first
        kept = np.repeat(end - np.cumsum(count), count) + np.arange(count.sum())
        return Tally(
            self.confidence[kept], self.hit[kept], np.repeat(np.arange(len(images)), count), self.truths[images]
        )

    def mistakes(self, threshold: float) -> tuple[np.ndarray, np.ndarray]:
        """False positives and misses (I,) of each image, of what was found with at least that confidence."""
        kept = self.confidence >= threshold
        found = np.bincount(self.image[kept], minlength=len(self.truths))
        hits = np.bincount(self.image[kept & self.hit], minlength=len(self.truths))
        return found - hits, self.truths - hits


POINTS, SLOTS = "points", "slots"
"""What can be found."""


@attrs.frozen(eq=False)
class Judged:
    """What a detector found in a set of images, matched with what is there.

    Attributes
    ----------
    names : tuple of str
        Of the images, each its own.
    groups : tuple of dict of str to str
        `Example.groups` of each.
    points : Tally
    slots : Tally or None
        None where the labels are points alone.
    """

    names: tuple[str, ...]
    groups: tuple[dict[str, str], ...]
    points: Tally
    slots: Tally | None

    @property
    def kinds(self) -> dict[str, Tally]:
        """The tallies by what was to be found; slots, where they are labelled, first."""
        return {POINTS: self.points} if self.slots is None else {SLOTS: self.slots, POINTS: self.points}

    def by(self, group: str) -> dict[str, Judged]:
        """What was found in the images of each place, side …, by its name; "" holds those of which it is not known."""
        members: dict[str, list[int]] = {}
        for position, groups in enumerate(self.groups):
            members.setdefault(groups.get(group, ""), []).append(position)
        return {name: self._of(np.array(members[name])) for name in sorted(members)}

    def _of(self, images: np.ndarray) -> Judged:
        return Judged(
            tuple(self.names[image] for image in images),
            tuple(self.groups[image] for image in images),
            self.points.of(images),
            None if self.slots is None else self.slots.of(images),
        )

    def clusters(self, group: str | None = None) -> list[tuple[bool, str]]:
        """For each image what it is drawn with: all those of its group, or it alone where that is not known."""
        return [
            (True, groups[group]) if groups.get(group) else (False, name)
            for name, groups in zip(self.names, self.groups, strict=True)
        ]
