"""Records (frozen attrs classes) in and out of plain data, with errors that name the field.

The Scene and the job file are both records: one reader serves JSON and TOML.
"""

from __future__ import annotations

import difflib
import json
import math
import reprlib
import types
import typing
from pathlib import Path
from typing import Any, TypeVar

import attrs
from cattrs import Converter, transform_error
from cattrs.errors import ForbiddenExtraKeysError
from cattrs.gen import make_dict_structure_fn, make_dict_unstructure_fn

from pavemark.errors import InputError

T = TypeVar("T")


@attrs.frozen
class Within:
    """What `within` makes: its bounds can be asked for, as a slider does."""

    low: float
    high: float

    def __call__(self, instance: Any, attribute: attrs.Attribute, value: Any) -> None:
        for number in _flat(value):
            if not (math.isfinite(number) and self.low <= number <= self.high):
                raise ValueError(f"{attribute.name} = {number}: allowed {self.low:g} to {self.high:g}")


def within(low: float, high: float) -> Within:
    """Validator: a finite number in [low, high], or a (nested) tuple of such numbers."""
    return Within(low, high)


def interval(low: float, high: float):
    """Validator: a pair (a, b) with low <= a <= b <= high, from which a value is drawn."""

    def check(instance: Any, attribute: attrs.Attribute, value: tuple[float, float]) -> None:
        a, b = value
        if not (math.isfinite(a) and math.isfinite(b) and low <= a <= b <= high):
            raise ValueError(
                f"{attribute.name} = [{a}, {b}]: allowed are two ascending numbers within {low:g} to {high:g}"
            )

    return check


@attrs.frozen
class OneOf:
    """What `one_of` makes: the words can be asked for, as a menu does."""

    allowed: tuple[str, ...]

    def __call__(self, instance: Any, attribute: attrs.Attribute, value: Any) -> None:
        for word in value if isinstance(value, tuple) else (value,):
            if word not in self.allowed:
                raise ValueError(f"{attribute.name} = {word!r}: allowed {', '.join(self.allowed)}")


def one_of(*allowed: str) -> OneOf:
    """Validator: one of the given words, or a tuple of them."""
    return OneOf(allowed)


def bounds(attribute: attrs.Attribute, kind: type[T]) -> T | None:
    """The validator of a field that is of a kind, `Within` or `OneOf`; None where it has none."""
    given = attribute.validator
    # Of several attrs makes one that holds them.
    each = getattr(given, "_validators", (given,))
    return next((one for one in each if isinstance(one, kind)), None)


def optional_records(cls: type) -> dict[str, type]:
    """The fields of a record that are another record or None, such as the effects of a scene, with their classes."""
    found = {}
    for name, hint in typing.get_type_hints(cls).items():
        record, *none = typing.get_args(hint) or (None,)
        if none == [type(None)] and attrs.has(record):
            found[name] = record
    return found


def _flat(value: Any):
    if isinstance(value, tuple):
        for item in value:
            yield from _flat(item)
    else:
        yield value


def _number(value: Any, kind: type) -> Any:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{value!r} is not a number")
    if not math.isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
    if kind is int and value != int(value):
        raise ValueError(f"{value!r} is not a whole number")
    return kind(value)


def _exact(value: Any, kind: type) -> Any:
    if not isinstance(value, kind):
        raise ValueError(f"{value!r} is not a {kind.__name__}")
    return value


def _words(value: Any) -> tuple[str, ...]:
    # A word alone would be taken for the list of its letters.
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{value!r} is not a list")
    return tuple(_exact(word, str) for word in value)


def _table(cls: type, converter: Converter):
    fill = make_dict_structure_fn(cls, converter, _cattrs_forbid_extra_keys=True)

    def structured(value: Any, kind: type) -> Any:
        if not isinstance(value, dict):
            raise ValueError(f"{reprlib.repr(value)} is not a table of fields")
        return fill(value, kind)

    return structured


def _converter() -> Converter:
    converter = Converter(forbid_extra_keys=True, detailed_validation=True)
    for kind in (int, float):
        converter.register_structure_hook(kind, lambda value, _, kind=kind: _number(value, kind))
    for kind in (str, bool):
        converter.register_structure_hook(kind, lambda value, _, kind=kind: _exact(value, kind))
    converter.register_structure_hook_func(lambda kind: kind == tuple[str, ...], lambda value, _: _words(value))
    converter.register_structure_hook_factory(attrs.has, lambda cls: _table(cls, converter))
    converter.register_unstructure_hook_factory(
        attrs.has,
        lambda cls: make_dict_unstructure_fn(cls, converter, _cattrs_omit_if_default=True),
    )
    return converter


_CONVERTER = _converter()


def structure(cls: type[T], data: Any, where: object) -> T:
    """Build a record of class `cls` from plain data.

    Parameters
    ----------
    cls : type
        A frozen attrs class.
    data : Any
        Nested dicts, lists, strings and numbers as JSON or TOML give them.
    where : object
        The file, named in errors.

    Raises
    ------
    InputError
        For an unknown field, a missing one, a wrong type or a value out of range; all faults in one line.
    """
    try:
        return _CONVERTER.structure(data, cls)
    except Exception as error:
        faults = transform_error(error, path="", format_exception=_say)
        told = "; ".join(_tidy(fault) for fault in faults)
        raise InputError(where, told or str(error)) from None


def _say(error: BaseException, kind: type | None) -> str:
    if isinstance(error, ForbiddenExtraKeysError):
        known = sorted(field.name for field in attrs.fields(error.cl))
        unknown = sorted(error.extra_fields)
        meant = [near[0] for near in (difflib.get_close_matches(field, known, 1) for field in unknown) if near]
        asked = f"did you mean {', '.join(meant)}? " if meant else ""
        return f"unknown field {', '.join(unknown)} ({asked}known: {', '.join(known)})"
    if isinstance(error, KeyError):
        return f"field {error.args[0]} is missing"
    if isinstance(error, TypeError):
        return f"wrong type, {_name(kind)} expected" if kind else str(error)
    told, of_another_length, wanted = str(error).partition(" to structure as tuple")
    if of_another_length:
        return f"{told[0].lower()}{told[1:]}: {wanted.count(',') + 1} are allowed"
    return str(error)


def _name(kind: Any) -> str:
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        return " or ".join(_name(part) for part in typing.get_args(kind) if part is not type(None))
    return getattr(kind, "__name__", str(kind))


def _tidy(fault: str) -> str:
    told, _, path = fault.rpartition(" @ ")
    path = path.lstrip(".")
    return f"{path}: {told}" if path else told


def unstructure(record: Any) -> Any:
    """The record as plain data; fields at their default are left out."""
    return _CONVERTER.unstructure(record)


def to_json(record: Any) -> str:
    """The record as JSON text, the same text for the same record on every platform."""
    return json.dumps(unstructure(record), indent=1, sort_keys=True, allow_nan=False) + "\n"


def from_json(cls: type[T], path: Path) -> T:
    """Read a record from a JSON file.

    Raises
    ------
    InputError
        When the file cannot be read, is not JSON or is not such a record.
    """
    return structure(cls, read_json(path), path)


def read_json(path: Path) -> Any:
    """Read a JSON file as plain data.

    Raises
    ------
    InputError
        When the file cannot be read, is not JSON or holds a number that is not finite.
    """

    def refuse(constant: str) -> float:
        raise ValueError(f"{constant} is not a finite number")

    try:
        # Editors of some systems put a byte order mark before the text.
        return json.loads(Path(path).read_text(encoding="utf-8-sig"), parse_constant=refuse)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"not a JSON file: {error}") from None
