"""What several detectors say together: affirmative, unanimous and consensus votes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pavemark.evaluate.found import Found, Marks
from pavemark.evaluate.matching import distances

VOTES: dict[str, Callable[[int, int], bool]] = {
    "affirmative": lambda votes, of: votes > 0,
    "unanimous": lambda votes, of: votes == of,
    "consensus": lambda votes, of: 2 * votes > of,
}
"""Whether what so many of so many detectors have found is kept: found by any, by all, by more than half."""


def voted(found: Sequence[Found], vote: str, radius: float) -> Found:
    """What detectors find together in one image; points and slots each by themselves.

    Parameters
    ----------
    found : sequence of Found
        Of each detector. Neither their order nor that within them matters.
    vote : str
        One of `VOTES`.
    radius : float
        Pixels within which two detectors mean the same, as in `pavemark.evaluate.matching.matched`.
    """
    return Found(
        _voted([each.points for each in found], VOTES[vote], radius),
        _voted([each.slots for each in found], VOTES[vote], radius),
    )


def _voted(marks: Sequence[Marks], kept: Callable[[int, int], bool], radius: float) -> Marks:
    """Of each group that has the votes its mean: places weighted by confidence, and the members' mean confidence."""
    merged = [_mean(group) for group in groups(marks, radius) if kept(len(group.confidence), len(marks))]
    width = marks[0].places.shape[1]
    places = np.array([place for place, _ in merged]).reshape(-1, width)
    made = Marks(places, np.array([confidence for _, confidence in merged], np.float64))
    order = made.order()
    return Marks(made.places[order], made.confidence[order])


def groups(marks: Sequence[Marks], radius: float) -> list[Marks]:
    """What detectors mean the same by: each thing found is in one group, and a group has at most one of a detector.

    The most confident of all that is in no group yet founds one, and each other detector adds the nearest of its own
    that is in none and nearer than `radius` to the founder. Equally confident ones come by place, as in `Marks.order`;
    of those as near the one that comes first is added.

    Returns
    -------
    list of Marks
        The founder first, then the others as they come in the order of all.
    """
    every = Marks(np.concatenate([each.places for each in marks]), np.concatenate([each.confidence for each in marks]))
    by = np.repeat(np.arange(len(marks)), [len(each.confidence) for each in marks])
    order = every.order()
    every, by = Marks(every.places[order], every.confidence[order]), by[order]
    free = np.ones(len(by), bool)
    made = []
    for founder in range(len(by)):
        if not free[founder]:
            continue
        apart = distances(every.places[founder : founder + 1], every.places)[0]
        members = [founder]
        for detector in range(len(marks)):
            near = np.flatnonzero(free & (by == detector) & (apart < radius))
            if detector != by[founder] and len(near):
                members.append(near[apart[near].argmin()])
        free[members] = False
        members.sort()
        made.append(Marks(every.places[members], every.confidence[members]))
    return made


def _mean(group: Marks) -> tuple[np.ndarray, float]:
    """Members come in the order of all, so that sums are the same whatever the order given."""
    weights = group.confidence if group.confidence.any() else np.ones(len(group.confidence))
    return (weights[:, None] * group.places).sum(0) / weights.sum(), group.confidence.mean()
