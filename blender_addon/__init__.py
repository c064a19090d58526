"""The only code that imports bpy: the extension `pavemark`, and the stage that it and render.py share."""


def register() -> None:
    """Make the extension's classes, properties and handlers known to Blender."""
    from . import registration  # noqa: PLC0415 - a worker draws, and needs no panel

    registration.register()


def unregister() -> None:
    """Take all of it back."""
    from . import registration  # noqa: PLC0415

    registration.unregister()
