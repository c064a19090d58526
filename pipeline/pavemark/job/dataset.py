"""The files of a whole dataset, made from the journals of all its shards."""

from __future__ import annotations

import json
from pathlib import Path

from pavemark import files
from pavemark.job import journal
from pavemark.job.folder import Folder
from pavemark.labels import coco


def join(folder: Folder) -> None:
    """Write manifest.jsonl and coco.json of all images that are there, in the order of their numbers.

    Whichever shard is joined last has seen the others. Files that already hold every line are left alone.

    Raises
    ------
    InputError
        When they cannot be written.
    """
    out = folder.out
    wanted = [out / "manifest.jsonl"] + [coco_json(out)] * ("coco" in folder.formats)
    with journal.merging(out):
        if all(path.exists() and path.stat().st_mtime_ns > journal.newest(out) for path in wanted):
            return
        finished = folder.finished().values()
        if coco_json(out) in wanted:
            parts = coco.dataset(json.loads(beside) for _, beside in journal.lines(finished))
            files.write_parts(coco_json(out), (part.encode() for part in parts))
        files.write_parts(out / "manifest.jsonl", (row + b"\n" for row, _ in journal.lines(finished)))


def coco_json(out: Path) -> Path:
    """Where the COCO labels of a dataset lie."""
    return out / "labels" / "coco.json"
