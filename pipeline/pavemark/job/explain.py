"""What a scene calls for, in words: effects with their parameters, passes and steps, and what it does without."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import attrs

from pavemark.plan import LIGHT, PAINT_EFFECTS, plan
from pavemark.records import from_json
from pavemark.scene import Scene

SCENE_EFFECTS = ("tyres", "curvature", "optics", "blend", *LIGHT, "brightness", "noise")


def explanation(scene: Scene) -> dict[str, Any]:
    """What a scene calls for, as plain data.

    Returns
    -------
    dict
        "plate", "slots" and "markings" (what is painted, bottom first, each with its paint's effects), "effects" of
        the whole image, "passes" that are rendered, "steps" that follow, and "without": effects that the scene does
        not call for, for which no node is built, no pass rendered and no step run.
    """
    todo = plan(scene)
    markings = [
        {
            "kind": marking.kind,
            "strokes": len(marking.strokes),
            "areas": len(marking.areas),
            "colour": marking.paint.ratio if todo.colour == "ratio" else marking.paint.rgb,
            "opacity": marking.paint.opacity,
            "effects": {name: attrs.asdict(getattr(marking.paint, name)) for name in nodes},
        }
        for marking, nodes in zip(scene.markings, todo.nodes, strict=True)
    ]
    effects = {name: attrs.asdict(effect) for name in SCENE_EFFECTS if (effect := getattr(scene, name)) is not None}
    called = {name for nodes in todo.nodes for name in nodes} | effects.keys()
    passes = [{"name": each.name, "samples": each.samples} for each in todo.passes]
    return {
        "index": scene.index,
        "plate": attrs.asdict(scene.plate),
        "slots": [{"kind": slot.kind, "outline": slot.outline, "marks": slot.marks} for slot in scene.slots],
        "markings": markings,
        "effects": effects,
        "colour": todo.colour,
        "passes": passes,
        "steps": list(todo.steps),
        "without": [name for name in (*PAINT_EFFECTS, *SCENE_EFFECTS) if name not in called],
    }


def explain_json(path: Path) -> str:
    """The explanation of a scene file as JSON text.

    Raises
    ------
    InputError
        When it is not a scene.
    """
    return json.dumps(explanation(from_json(Scene, path)), indent=1)


def explain(path: Path) -> str:
    """The explanation of a scene file as text to read.

    Raises
    ------
    InputError
        When it is not a scene.
    """
    scene = from_json(Scene, path)
    told = explanation(scene)
    frame = scene.plate.frame
    lines = [
        f"image {scene.index} on plate {scene.plate.name}, "
        f"{frame.width}×{frame.height} px at {frame.scale:.4g} px/m: {frame.size[0]:.4g} m × {frame.size[1]:.4g} m",
        "",
        _line("slots", _counted(f"{slot.kind}, {slot.outline}, {'/'.join(slot.marks)}" for slot in scene.slots)),
    ]
    for number, marking in enumerate(told["markings"], 1):
        lines += ["", _line(f"marking {number}", _marking(marking, told["colour"]))]
        lines += [_line(f"  {name}", _parameters(effect)) for name, effect in marking["effects"].items()]
    lines += ["", _line("whole image", "" if told["effects"] else "no effect")]
    lines += [_line(f"  {name}", _parameters(effect)) for name, effect in told["effects"].items()]
    passes = [
        f"{each['name']}, {each['samples']} ray{'' if each['samples'] == 1 else 's'} a pixel" for each in told["passes"]
    ]
    lines += [
        "",
        _line("passes", "; ".join(passes) or "none: Blender is not started"),
        _line("steps", " → ".join(told["steps"]) or "none: the plate as it is"),
        _line("without", ", ".join(told["without"]) or "nothing"),
    ]
    return "\n".join(line.rstrip() for line in lines)


def _line(name: str, text: str) -> str:
    return f"{name:<14}{text}"


def _counted(things: Any) -> str:
    return "; ".join(f"{count} × {thing}" for thing, count in Counter(things).items()) or "none"


def _marking(marking: dict[str, Any], colour: str) -> str:
    drawn = [f"{marking[what]} {what}" for what in ("strokes", "areas") if marking[what]]
    paint = " ".join(_value(number) for number in marking["colour"])
    meant = "× the ground's reflectance" if colour == "ratio" else "of 255"
    opacity = _value(marking["opacity"])
    return f"{marking['kind']}: {', '.join(drawn) or 'nothing'}; colour {paint} {meant}, opacity {opacity}"


def _parameters(effect: dict[str, Any]) -> str:
    return ", ".join(f"{name} {_value(value)}" for name, value in effect.items() if value is not None)


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return f"({_parameters(value)})"
    if isinstance(value, (list, tuple)) and value and isinstance(value[0], dict):
        return ", ".join(f"{count} {kind}" for kind, count in Counter(each.get("kind", "") for each in value).items())
    if isinstance(value, (list, tuple)):
        numbers = [number for number in _flat(value) if isinstance(number, (int, float))]
        return f"{len(numbers)} numbers, {min(numbers):.4g} to {max(numbers):.4g}" if numbers else "none"
    return str(value)


def _flat(value: Any) -> list[Any]:
    return [leaf for item in value for leaf in _flat(item)] if isinstance(value, (list, tuple)) else [value]
