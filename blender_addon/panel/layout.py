"""What the subpanels have in common."""

import textwrap

from ..properties.fields import shown

WIDTH = 6.5
"""Pixels of a letter at a scale of 1."""


class Sub:
    """Mixed into a subpanel of the sidebar's tab."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Pavemark"
    bl_parent_id = "PAVEMARK_PT_root"


class Switched(Sub):
    """Mixed into a subpanel that is off until it is switched on."""

    bl_options = {"DEFAULT_CLOSED"}
    group = ""
    """The group of `Scene.pavemark` that it shows; its `use` is the switch."""

    def draw_header(self, context):
        self.layout.prop(getattr(context.scene.pavemark, self.group), "use", text="")

    def draw(self, context):
        told = getattr(context.scene.pavemark, self.group)
        layout = columns(self.layout)
        layout.active = told.use
        self.fields(layout, told)

    def fields(self, layout, told):
        """Draw what the group holds beside its switch."""
        for name in type(told).__annotations__:
            if name != "use":
                layout.prop(told, name)


def columns(layout):
    """A column whose labels stand left of what they name."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()


def record(layout, group, kind: type) -> None:
    """What can be shown of a record."""
    for name in shown(kind):
        if name in group.bl_rna.properties:
            layout.prop(group, name)
    if not shown(kind):
        layout.label(text="Drawn or measured: nothing to set")


def say(context, layout, text: str, icon: str = "NONE", alert: bool = False) -> None:
    """A sentence over as many lines as the sidebar is narrow."""
    # Without a window neither has a size.
    width = context.region.width / (context.preferences.system.ui_scale or 1.0) if context.region else 300
    letters = max(16, int(width / WIDTH) - 6)
    column = layout.column(align=True)
    column.alert = alert
    column.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon=icon if number == 0 else ("NONE" if icon == "NONE" else "BLANK1"))


def outcome(context, layout, told: tuple[str, str] | None) -> None:
    """What came of a process: "INFO", "WARNING" or "ERROR", and a line."""
    if told is not None:
        kind, line = told
        say(context, layout, line, {"INFO": "CHECKMARK", "WARNING": "ERROR", "ERROR": "CANCEL"}[kind], kind == "ERROR")


def progress(layout, child, running: str) -> None:
    """How far a process is, and the button that stops it."""
    row = layout.row(align=True)
    told = f"{child.done} of {child.total}  ·  {child.rate}/s  ·  {child.left} left" if child.total else "starting …"
    row.progress(factor=child.part, text=told)
    row.operator("pavemark.stop", text="", icon="CANCEL").what = running
