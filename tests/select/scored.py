"""Detectors that look at nothing but how bright an image is, folders of scores, and tables of candidates."""

import attrs
import numpy as np

from pavemark.detect.reading import examples
from pavemark.select import shards
from pavemark.select.candidate import Candidate
from pavemark.select.origin import dataset_hash, mark, selection_hash
from pavemark.select.shards import Origin, Row


class Fake:
    """A detector: every cell has the confidence and the place that the mean of the image is, 0 to 1."""

    family = "dmpr"

    def __init__(self, version="fake", cells=(3, 2), told=None, beyond=(0, 0)):
        self.version = version
        self.beyond = beyond
        self.told = told or (lambda mean: (np.full((*cells, 3), mean), np.array([mean, 1.0])))
        self.seen = []

    def covered(self, frame):
        return frame.width + self.beyond[0], frame.height + self.beyond[1]

    def look(self, image, frame):
        self.seen.append(image)
        return self.told(image.mean() / 255)

    def grid(self, image, frame):
        return self.look(image, frame)[0]

    def embedding(self, image, frame):
        return self.look(image, frame)[1]


class Watcher:
    """Keeps what it is told."""

    def __init__(self):
        self.total, self.steps, self.lines = None, [], []

    def of(self, total):
        self.total = total
        return self

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def step(self, lacking):
        self.steps.append(lacking)

    def tell(self, line):
        self.lines.append(line)


ORIGIN = Origin("model", "dmpr", "dataset", "", {"numpy": "2"})


def scores(folder, dataset, rows, origin=ORIGIN, size=1024):
    """A folder of scores of a dataset as it is; rows are (name, loss), with plate, domain and embedding if told."""
    origin = attrs.evolve(origin, dataset=dataset_hash(dataset), listed=selection_hash(dataset))
    marks = {example.name: mark(example) for example in examples(dataset)}
    made = [row(*each) for each in rows]
    made = [attrs.evolve(each, mark=marks.get(each.name, each.mark)) for each in made]
    for number in range(-(-len(made) // size)):
        shards.write(shards.path_of(folder, number), number, made[number * size : (number + 1) * size], origin)
    return folder


def row(name, loss, plate=None, domain=None, embedding=(1.0, 0.0)):
    groups = {"plate": plate, "domain": domain}
    return Row(name, loss, {k: v for k, v in groups.items() if v is not None}, tuple(map(float, embedding)), b"m" * 16)


def table(rng, count, tied=True, unknown=True):
    """Candidates with few losses, domains and plates, so that much is tied; in no order."""
    losses = rng.integers(0, 5, count) / 7 if tied else rng.random(count)
    domains = [*"ab", None] if unknown else [*"abc"]
    names = rng.permutation([f"images/{k:03d}" for k in range(count)])
    return [
        Candidate(str(name), float(loss), f"p{rng.integers(4)}", domains[rng.integers(3)])
        for name, loss in zip(names, losses, strict=True)
    ]
