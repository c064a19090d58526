"""Presets of the panel's settings: kept by Blender among the user's own, never in the extension's folder."""

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase

from pavemark.errors import InputError

from .. import edits
from ..effects import EFFECTS
from ..properties.fields import shown
from .reporting import Reporting

SUBFOLDER = "pavemark"
_HELD = {
    "count": ("use", "slots", "both_sides"),
    "shape": ("use", "kind", "slant"),
    "outline": ("use", "kind"),
    "line": ("use", "width"),
    "colour": ("use", "family", "rgb", "ratio", "opacity"),
}
_ROOT = ("preset", "draw", "max_error", "batch_count", "formats", "workers")


def _values() -> list[str]:
    effects = {name: ("use", *shown(record)) for name, record in EFFECTS.items()}
    groups = _HELD | effects
    return [f"settings.{name}" for name in _ROOT] + [
        f"settings.{group}.{field}" for group, fields in groups.items() for field in fields
    ]


class PAVEMARK_MT_presets(bpy.types.Menu):
    """Settings that were kept"""

    bl_label = "Pavemark Presets"
    preset_subdir = SUBFOLDER
    preset_operator = "pavemark.apply_preset"
    draw = bpy.types.Menu.draw_preset


class PAVEMARK_OT_apply_preset(Reporting, bpy.types.Operator):
    """Take the settings that were kept under this name, and give the scene what they say"""

    bl_idname = "pavemark.apply_preset"
    bl_label = "Apply Pavemark Preset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    menu_idname: bpy.props.StringProperty(options={"SKIP_SAVE"})

    def act(self, context):
        path = Path(self.filepath)
        try:
            bpy.utils.execfile(str(path))
        except (OSError, SyntaxError, AttributeError, TypeError, NameError) as error:
            raise InputError(path, f"is not a preset of this panel: {error}") from None
        edits.apply(context.scene)
        PAVEMARK_MT_presets.bl_label = bpy.path.display_name(path.stem)


class PAVEMARK_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Keep these settings under a name, or remove those of that name"""

    bl_idname = "pavemark.add_preset"
    bl_label = "Add Pavemark Preset"
    preset_menu = "PAVEMARK_MT_presets"
    preset_defines = ["settings = bpy.context.scene.pavemark"]
    preset_values = _values()
    preset_subdir = SUBFOLDER


CLASSES = (PAVEMARK_MT_presets, PAVEMARK_OT_apply_preset, PAVEMARK_OT_add_preset)
