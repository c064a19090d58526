"""Runs inside a Blender with a window: the whole workflow by operators and clicks, photographed step by step.

blender --enable-event-simulate -P window.py -- DEMO OUT
"""

import json
import os
import shutil
import subprocess
import sys
import traceback
from pathlib import Path

import bpy
import cv2

DEMO, OUT = map(Path, sys.argv[sys.argv.index("--") + 1 :])
PACKAGE = "bl_ext.user_default.pavemark"
told = {}
bpy.context.preferences.view.show_splash = False


def window():
    return bpy.context.window_manager.windows[0]


def area(kind="VIEW_3D"):
    return next(area for area in window().screen.areas if area.type == kind)


def region(kind="WINDOW", of="VIEW_3D"):
    return next(region for region in area(of).regions if region.type == kind)


def do(operator, where="WINDOW", *how, **settings):
    """Call an operator where a click would."""
    with bpy.context.temp_override(window=window(), area=area(), region=region(where)):
        return operator(*how, **settings)


def settings():
    return window().scene.pavemark


def module(name):
    return sys.modules[f"{PACKAGE}.{name}"]


def photograph(name):
    """What the window shows, by ImageMagick where it is there: of a graphics card that a program plays Blender reads
    black."""
    path = str(OUT / f"{name}.png")
    with bpy.context.temp_override(window=window(), area=area()):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
        if shutil.which("import"):
            subprocess.run(["import", "-window", "root", path], check=True)
        else:
            bpy.ops.screen.screenshot(filepath=path)


def shows_the_ground(name):
    """Whether the middle of the photographed view is textured, as the image is and an empty view is not."""
    middle, whole = region(), window()
    image = cv2.imread(str(OUT / f"{name}.png"), cv2.IMREAD_GRAYSCALE)
    # Blender counts rows from below.
    row, column = whole.height - middle.y - middle.height // 2, middle.x + middle.width // 2
    return image[row - 100 : row + 100, column - 100 : column + 100].std() > 5


def click(x, y):
    """Click on the ground, in metres."""
    from bpy_extras.view3d_utils import location_3d_to_region_2d  # noqa: PLC0415

    place = location_3d_to_region_2d(region(), area().spaces.active.region_3d, (x, y, 0.0))
    at = {"x": round(region().x + place.x), "y": round(region().y + place.y)}
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", **at)
    window().event_simulate(type="LEFTMOUSE", value="PRESS", **at)
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", **at)


def open_panels(*names):
    """Have these subpanels open, and no others; before the sidebar is drawn, which then keeps what is open."""
    classes = module("panel").CLASSES
    for each in reversed(classes):
        bpy.utils.unregister_class(each)
    for each in classes:
        short = each.__name__.removeprefix("PAVEMARK_PT_")
        closed = short not in ("root", *names)
        each.bl_options = {"DEFAULT_CLOSED"} if closed else set()
        bpy.utils.register_class(each)


def scroll(lines):
    """Scroll the sidebar to its start and then down by so many turns of the wheel, 40 pixels each."""
    for _ in range(100):
        do(bpy.ops.view2d.scroll_up, "UI")
    for _ in range(lines):
        do(bpy.ops.view2d.scroll_down, "UI")


def prepare():
    """An empty file, the sidebar with our tab, a wide view."""
    for shown in list(bpy.data.objects):
        bpy.data.objects.remove(shown)
    open_panels(
        *("background", "slots", "count", "line", "colour", "wear", "curvature", "noise", "effects", "optics", "blend"),
        *("render", "batch", "files"),
    )
    area().spaces.active.show_region_ui = True
    for other in list(window().screen.areas):
        if other.type in ("DOPESHEET_EDITOR", "OUTLINER"):
            with bpy.context.temp_override(window=window(), area=other):
                bpy.ops.screen.area_close()
    for other in list(window().screen.areas):
        if other.type == "PROPERTIES":
            with bpy.context.temp_override(window=window(), area=other):
                bpy.ops.screen.area_close()


def background():
    region("UI").active_panel_category = "Pavemark"
    chosen = settings().background
    # Relative to where we are: photographs show no path of a machine.
    os.chdir(DEMO)
    chosen.masks, chosen.ground = "masks", "0"
    chosen.images = "images"
    told["trouble"] = settings().trouble
    do(bpy.ops.pavemark.step_background, step=1)
    do(bpy.ops.pavemark.look_down)


def remove():
    photograph("1-background")
    # The first view is empty while shaders compile: seconds, and a minute on a busy machine.
    told["looks"] = told.get("looks", 0) + 1
    told["ground_seen"] = bool(shows_the_ground("1-background"))
    if not told["ground_seen"] and told["looks"] < 60:
        area().tag_redraw()
        return 2.0
    do(bpy.ops.pavemark.remove_markings)
    return None


def removed():
    if module("running").children:
        return 0.5
    told["removed"] = module("running").outcomes.get("Remove markings")
    told["clean"] = settings().background.clean
    settings().count.use, settings().count.slots = True, 3
    settings().seed = 4
    do(bpy.ops.pavemark.randomize)
    told["drawn"] = len(module("document").known(window().scene).slots)
    for name in ("wear", "grain", "curvature", "optics"):
        getattr(settings(), name).use = True
    return None


def slots():
    photograph("2-slots")
    scroll(14)
    photograph("2-slots-down")
    scroll(0)
    do(bpy.ops.pavemark.new_slot, "WINDOW", "INVOKE_DEFAULT")


def first():
    click(-1.6, -0.4)


def second():
    click(-1.6, -3.0)


def third():
    photograph("3-new-slot")
    click(-4.4, -1.7)


def new():
    scene = module("document").current(window().scene)
    told["with_new"] = len(scene.slots)
    told["new_corners"] = scene.slots[-1].corners
    bpy.ops.ed.undo_push(message="a new slot")
    shown = [each for each in window().scene.objects if "pavemark_marking" in each][-1]
    told["before_drag"] = scene.slots[-1].corners
    shown.location.x -= 0.25


def dragged():
    # The depsgraph has told of it, and the timer has followed: nobody asked.
    scene = module("document").known(window().scene)
    told["after_drag"] = scene.slots[-1].corners
    told["trouble"] += settings().trouble
    do(bpy.ops.pavemark.open_editor)
    do(bpy.ops.pavemark.render)


def rendered():
    scroll(30)
    settings().folder = os.path.relpath(OUT / "dataset")
    do(bpy.ops.pavemark.save_image)
    told["saved"] = sorted(str(path.relative_to(OUT)) for path in (OUT / "dataset").rglob("*.png"))
    for shown in region("WINDOW", "IMAGE_EDITOR"), region():
        shown.tag_redraw()
    with bpy.context.temp_override(window=window(), area=area("IMAGE_EDITOR"), region=region("WINDOW", "IMAGE_EDITOR")):
        bpy.ops.image.view_all(fit_view=True)
    do(bpy.ops.pavemark.look_down)


def labelled():
    photograph("4-render")
    settings().batch_folder = os.path.relpath(OUT / "batch")
    settings().batch_count, settings().workers = 6, 1
    do(bpy.ops.pavemark.batch)
    scroll(60)


def running():
    children = module("running").children
    child = children.get("Batch")
    if child is None or not child.done:
        return 0.5 if child else None
    photograph("5-batch")
    do(bpy.ops.pavemark.stop, what="Batch")
    return None


def stopped():
    if module("running").children:
        return 0.5
    told["batch"] = module("running").outcomes.get("Batch")
    photograph("6-stopped")
    do(bpy.ops.pavemark.open_scene, filepath=str(next((OUT / "batch" / "scenes").glob("*.json"))))
    return None


def opened():
    photograph("7-opened")
    told["opened"] = settings().background.name
    told["done"] = True
    return None


STEPS = [
    (2.0, prepare), (2.0, background), (4.0, remove), (9.0, removed), (5.0, slots), (1.0, first), (0.7, second),
    (0.7, third), (1.0, new), (1.5, dragged), (1.5, rendered), (4.0, labelled), (2.0, running), (2.0, stopped),
    (4.0, opened),
]  # fmt: skip


def tick():
    _, act = STEPS[0]
    try:
        again = act()
    except Exception:
        told["failed"] = f"{act.__name__}: {traceback.format_exc()}"
        photograph("failed")
        STEPS.clear()
    else:
        if again is not None:
            return again
        STEPS.pop(0)
    if STEPS:
        return STEPS[0][0]
    (OUT / "told.json").write_text(json.dumps(told, indent=1))
    bpy.ops.wm.quit_blender()
    return None


bpy.app.timers.register(tick, first_interval=STEPS[0][0], persistent=True)
