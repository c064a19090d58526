"""Scores in Parquet files of a fixed number of rows: a file is whole or not there, and says whose scores it holds."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Sequence
from pathlib import Path

import attrs
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pavemark import files
from pavemark.errors import InputError

KIND = "scores 1"
"""What a file says that it is."""

_KIND, _ORIGIN, _PART = b"pavemark", b"origin", b"part"

_NAME = re.compile(r"scores-(\d{6,})\.parquet")


class Broken(Exception):
    """A file that is no whole shard: cut short, or with bits that are not those that were written."""


@attrs.frozen
class Row:
    """What is known of an image.

    Attributes
    ----------
    name : str
        Of the image in its dataset.
    loss : float
        Point loss.
    groups : dict of str to str
        As `pavemark.detect.example.Example` has them.
    embedding : tuple of float
        What the image looks like to the detector, numbers of single precision.
    mark : bytes
        Of the labels and the file that were scored: what has changed since is scored anew.
    """

    name: str
    loss: float
    groups: dict[str, str]
    embedding: tuple[float, ...]
    mark: bytes


@attrs.frozen
class Origin:
    """Whose scores they are. Those of two origins are not to be compared.

    Attributes
    ----------
    model : str
        Hash of the detector.
    family : str
    dataset : str
        Hash of what the dataset is, whatever images of it are listed.
    listed : str
        Hash of the selection that is scored; empty where it is the dataset itself.
    versions : dict of str to str
        Of the libraries that the numbers depend on.
    """

    model: str
    family: str
    dataset: str
    listed: str
    versions: dict[str, str]


def path_of(folder: Path, number: int) -> Path:
    """Where shard `number` of a folder lies."""
    return folder / f"scores-{number:06d}.parquet"


def there(folder: Path) -> dict[int, Path]:
    """The shards of a folder by number, ascending; they may be broken."""
    found = {}
    if folder.is_dir():
        for path in folder.iterdir():
            if match := _NAME.fullmatch(path.name):
                found[int(match[1])] = path
    return dict(sorted(found.items()))


def write(path: Path, number: int, rows: Sequence[Row], origin: Origin) -> None:
    """Write a shard, at least one row; the same rows give the same bytes.

    Parameters
    ----------
    path : Path
        Where it goes, as `path_of` tells it.
    number : int
        Of the shard in its folder; told in the file, so that one under another's name is noticed.
    rows : sequence of Row
        In the order of the dataset, with embeddings of one length.
    origin : Origin

    Raises
    ------
    InputError
        When it cannot be written.
    """
    across = len(rows[0].embedding)
    flat = np.array([row.embedding for row in rows], np.float32).reshape(len(rows), across)
    schema = _schema(across).with_metadata(
        {_KIND: KIND, _ORIGIN: json.dumps(attrs.asdict(origin), sort_keys=True), _PART: str(number)}
    )
    columns = [
        pa.array([row.name for row in rows], pa.string()),
        pa.array([row.loss for row in rows], pa.float64()),
        pa.array([row.groups.get("plate") or None for row in rows], pa.string()),
        pa.array([row.groups.get("domain") or None for row in rows], pa.string()),
        pa.array([sorted(row.groups.items()) for row in rows], _GROUPS),
        pa.FixedSizeListArray.from_arrays(pa.array(flat.ravel(), pa.float32()), across),
        pa.array([row.mark for row in rows], _MARK),
    ]
    stream = io.BytesIO()
    # Each page has its checksum: bits that flip on a disk are no scores.
    pq.write_table(pa.Table.from_arrays(columns, schema=schema), stream, compression="zstd", write_page_checksum=True)
    files.write(path, stream.getvalue())


def read(path: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """A shard as a table: name, loss, plate, domain, groups, embedding and mark, or those columns that are asked for.

    Raises
    ------
    Broken
        When it is no whole shard.
    InputError
        When it cannot be read, or is of another kind.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    try:
        file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
        schema, told = file.schema_arrow, file.schema_arrow.metadata or {}
        kind = told.get(_KIND, b"no scores").decode()
        if kind == KIND and not schema.equals(_schema(_across(schema))):
            raise ValueError("its columns are others")
        table = file.read(columns=None if columns is None else list(columns))
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        raise Broken(" ".join(str(error).split())[:200]) from None
    if kind != KIND:
        raise InputError(path, f'is of the kind "{kind}": "{KIND}", as pavemark score writes it, is allowed')
    return table


def rows(path: Path, number: int) -> tuple[Origin, list[Row]]:
    """The rows of shard `number`, and whose they are.

    Raises
    ------
    Broken, InputError
        As `read`; a shard under the number of another one is broken, too.
    """
    table = read(path)
    if table.schema.metadata.get(_PART) != str(number).encode():
        raise Broken("it is another shard")
    name, loss, _, _, groups, _, mark = (column.to_pylist() for column in table.itercolumns())
    embeddings = map(tuple, matrix(table).tolist())
    return origin_of(path, table), [
        Row(*each) for each in zip(name, loss, map(dict, groups), embeddings, mark, strict=True)
    ]


def origin_of(path: Path, table: pa.Table) -> Origin:
    """Whose scores a table holds.

    Raises
    ------
    Broken
        When it does not tell.
    """
    try:
        return Origin(**json.loads(table.schema.metadata[_ORIGIN]))
    except (KeyError, TypeError, ValueError):
        raise Broken(f"{path.name} does not tell whose scores it holds") from None


def matrix(table: pa.Table) -> np.ndarray:
    """The embeddings of a table, (N, E) float32."""
    column = table.column("embedding").combine_chunks()
    flat = column.flatten().to_numpy(zero_copy_only=False)
    return flat.reshape(len(column), column.type.list_size)


def _across(schema: pa.Schema) -> int:
    kind = schema.field("embedding").type
    if not pa.types.is_fixed_size_list(kind):
        raise ValueError("its embedding is no list of a fixed size")
    return kind.list_size


_GROUPS = pa.map_(pa.string(), pa.string())
_MARK = pa.binary(16)


def _schema(across: int) -> pa.Schema:
    return pa.schema(
        [
            pa.field("name", pa.string(), nullable=False),
            pa.field("loss", pa.float64(), nullable=False),
            pa.field("plate", pa.string()),
            pa.field("domain", pa.string()),
            pa.field("groups", _GROUPS, nullable=False),
            pa.field("embedding", pa.list_(pa.field("element", pa.float32(), nullable=False), across), nullable=False),
            pa.field("mark", _MARK, nullable=False),
        ]
    )
