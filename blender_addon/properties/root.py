"""`Scene.pavemark`: all that the panel keeps in a file."""

import bpy

from pavemark.background.finding import SEGMENTERS
from pavemark.background.inpainting import choices
from pavemark.job.config import FORMATS, PIXELS_PER_METRE, PRESETS

from .. import edits
from ..effects import EFFECTS
from .groups import (
    EFFECT_GROUPS,
    HELD,
    LIGHTS,
    BlendGroup,
    CasterGroup,
    LampGroup,
    PAVEMARK_PG_colour,
    PAVEMARK_PG_count,
    PAVEMARK_PG_line,
    PAVEMARK_PG_outline,
    PAVEMARK_PG_shape,
    SunGroup,
    TubesGroup,
)
from .hearing import heard


class PAVEMARK_PG_background(bpy.types.PropertyGroup):
    """The image that is painted on."""

    images: bpy.props.StringProperty(
        name="Images",
        description="An AVM image, a folder of them, or a folder that pavemark plates made",
        subtype="FILE_PATH",
        update=heard(edits.choose_background),
    )
    masks: bpy.props.StringProperty(
        name="Masks",
        description="Folder of marking masks: PNGs of the images' names. Without it the markings are looked for",
        subtype="DIR_PATH",
        update=heard(edits.choose_background),
    )
    marking: bpy.props.StringProperty(
        name="Marking", description="Values of a mask that are markings, such as 1, 3", default="1"
    )
    ground: bpy.props.StringProperty(
        name="Ground",
        description="Values of a mask that are bare ground, such as 0; empty: all that is no marking",
        default="",
        update=heard(edits.choose_background),
    )
    metres_per_pixel: bpy.props.FloatProperty(
        name="Pixel Size",
        description="Metres of ground that a pixel of the images shows",
        subtype="DISTANCE",
        unit="LENGTH",
        default=1 / PIXELS_PER_METRE,
        min=0.0001,
        max=1.0,
        step=0.01,
        precision=5,
        update=heard(edits.choose_background),
    )
    inpainter: bpy.props.EnumProperty(
        name="Fill",
        description="What fills the ground where markings were",
        items=[(name, name, "") for name in choices()],
        update=heard(edits.choose_background),
    )
    segmenter: bpy.props.EnumProperty(
        name="Find",
        description="What finds the markings of images without masks",
        items=[(name, name.capitalize(), "") for name in SEGMENTERS],
        default="network",
        update=heard(edits.choose_background),
    )
    name: bpy.props.StringProperty(name="Image", description="The image that is painted on")
    file: bpy.props.StringProperty(name="File", description="Its file name")
    size: bpy.props.IntVectorProperty(name="Size", description="Its pixels, across and down", size=2)
    clean: bpy.props.BoolProperty(name="Clean", description="Whether its markings have been removed")


class PAVEMARK_PG_scene(bpy.types.PropertyGroup):
    """The panel's settings, and the scene of Pavemark that they belong to."""

    document: bpy.props.StringProperty(name="Scene", description="The scene of Pavemark as JSON")
    trouble: bpy.props.StringProperty(name="Trouble", description="What could not be done", options={"SKIP_SAVE"})
    background: bpy.props.PointerProperty(type=PAVEMARK_PG_background)
    seed: bpy.props.IntProperty(
        name="Seed",
        description="Everything random follows from it: the seed of a job",
        default=0,
        min=0,
        update=heard(edits.draw),
    )
    index: bpy.props.IntProperty(
        name="Image Number",
        description="Number of the image in its job",
        default=0,
        min=0,
        update=heard(edits.renumber),
    )
    preset: bpy.props.EnumProperty(
        name="Preset",
        description="Ranges that settings are drawn from",
        items=[(name, name.capitalize(), "") for name in PRESETS],
        default="default",
    )
    draw: bpy.props.EnumProperty(
        name="Draw",
        description="What a draw decides",
        items=[
            ("switched", "Switched On", "Draw the effects that are switched on, and no others"),
            ("preset", "As the Preset", "Let chance switch effects on and off, as a job does"),
        ],
        default="switched",
    )
    count: bpy.props.PointerProperty(type=PAVEMARK_PG_count)
    shape: bpy.props.PointerProperty(type=PAVEMARK_PG_shape)
    outline: bpy.props.PointerProperty(type=PAVEMARK_PG_outline)
    line: bpy.props.PointerProperty(type=PAVEMARK_PG_line)
    colour: bpy.props.PointerProperty(type=PAVEMARK_PG_colour)
    blend: bpy.props.PointerProperty(type=BlendGroup)
    sun: bpy.props.PointerProperty(type=SunGroup)
    lamp: bpy.props.PointerProperty(type=LampGroup)
    casters: bpy.props.CollectionProperty(type=CasterGroup, description="What casts shadows into the image")
    tubes: bpy.props.PointerProperty(type=TubesGroup)
    max_error: bpy.props.FloatProperty(
        name="Max Error",
        description="Levels of 255 by which edges of paint may be off: the cheapest way that keeps it is taken; "
        "0 takes what ships",
        default=0.0,
        min=0.0,
        max=255.0,
        soft_max=16.0,
        step=50,
        precision=2,
    )
    overlay: bpy.props.BoolProperty(
        name="Labels",
        description="Draw marking points, entrance lines and numbers of slots over the image",
        default=True,
        update=lambda group, context: edits.redraw_editors(),
    )
    folder: bpy.props.StringProperty(
        name="Folder", description="Dataset that images and labels are saved into", subtype="DIR_PATH"
    )
    seconds: bpy.props.FloatProperty(name="Seconds", description="What the last render took")
    off: bpy.props.FloatProperty(
        name="Off", description="Levels that the table of rays promises of edges of the last render; -1 promises none"
    )
    batch_count: bpy.props.IntProperty(name="Count", description="Images to make", default=200, min=1)
    batch_folder: bpy.props.StringProperty(
        name="Folder", description="Where the batch's images and labels go", subtype="DIR_PATH"
    )
    formats: bpy.props.EnumProperty(
        name="Formats",
        description="Formats of the labels",
        items=[(name, name, "") for name in FORMATS],
        options={"ENUM_FLAG"},
        default=set(FORMATS),
    )
    workers: bpy.props.IntProperty(
        name="Workers", description="Processes that render at a time", default=2, min=1, max=1024
    )


PAVEMARK_PG_scene.__annotations__ |= {name: bpy.props.PointerProperty(type=EFFECT_GROUPS[name]) for name in EFFECTS}

CLASSES = (PAVEMARK_PG_background, *HELD, BlendGroup, *EFFECT_GROUPS.values(), *LIGHTS, PAVEMARK_PG_scene)
"""In the order in which they are registered: what is pointed at before what points."""
