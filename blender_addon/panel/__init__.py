"""The panel in the 3D view's sidebar, in the order of the work: a subpanel a file."""

from . import background, batch, effects, files, render, root, slots

CLASSES = (
    *root.CLASSES,
    *background.CLASSES,
    *slots.CLASSES,
    *effects.CLASSES,
    *render.CLASSES,
    *batch.CLASSES,
    *files.CLASSES,
)
