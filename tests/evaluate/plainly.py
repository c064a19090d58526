"""Judging once more, slowly and by definition: lists and loops, nothing of the code that is tested."""

import math


def matches(found, truth, radius):
    """Position in `truth` or None, for each of `found`: (confidence, place), a place being a tuple of numbers."""
    taken, given = set(), {}
    for k in sorted(range(len(found)), key=lambda k: (-found[k][0], found[k][1])):
        candidates = []
        for t, place in enumerate(truth):
            apart = math.sqrt(sum((a - b) ** 2 for a, b in zip(found[k][1], place, strict=True)))
            if t not in taken and apart < radius:
                candidates.append((apart, place, t))
        if candidates:
            given[k] = min(candidates)[2]
            taken.add(given[k])
    return [given.get(k) for k in range(len(found))]


def counts(images, threshold, radius):
    """Hits, false positives and misses of (found, truth) pairs, each image matched anew at the threshold."""
    hits = wrong = missed = 0
    for found, truth in images:
        kept = [each for each in found if each[0] >= threshold]
        right = sum(match is not None for match in matches(kept, truth, radius))
        hits, wrong, missed = hits + right, wrong + len(kept) - right, missed + len(truth) - right
    return hits, wrong, missed


def average_precision(images, radius):
    """For each thing that is there, counted 1 … T, the best precision of a threshold that finds so many."""
    total = sum(len(truth) for _, truth in images)
    every = [counts(images, t, radius) for t in {confidence for found, _ in images for confidence, _ in found}]
    best = []
    for wanted in range(1, total + 1):
        best.append(max((hits / (hits + wrong) for hits, wrong, _ in every if hits >= wanted), default=0.0))
    return sum(best) / total if total else math.nan


def best_threshold(images, radius):
    """By trying every confidence, in fractions' order: of as good ones the greatest; 1 where there is none."""
    scored = []
    for threshold in {confidence for found, _ in images for confidence, _ in found}:
        hits, wrong, missed = counts(images, threshold, radius)
        scored.append((2 * hits / (2 * hits + wrong + missed), threshold))
    return max(scored, default=(0, 1.0))[1]


def voted(detectors, needed, radius):
    """Means of the groups with at least `needed` members; `detectors` are lists of (confidence, place)."""
    left = [
        (-confidence, place, d, k) for d, each in enumerate(detectors) for k, (confidence, place) in enumerate(each)
    ]
    made = []
    while left:
        founder = min(left)
        group = [founder]
        for d in range(len(detectors)):
            near = [(math.dist(each[1], founder[1]), *each) for each in left if each[2] == d != founder[2]]
            near = [each for each in near if each[0] < radius]
            if near:
                group.append(min(near)[1:])
        left = [each for each in left if each not in group]
        if len(group) >= needed:
            weights = [-each[0] for each in group]
            if not any(weights):
                weights = [1.0] * len(group)
            place = tuple(
                sum(w * each[1][axis] for w, each in zip(weights, group, strict=True)) / sum(weights)
                for axis in range(len(founder[1]))
            )
            made.append((sum(-each[0] for each in group) / len(group), place))
    return sorted(made, key=lambda each: (-each[0], each[1]))
