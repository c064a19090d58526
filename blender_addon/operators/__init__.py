"""The operators, by subject."""

from . import background, batch, drawing, files, presets, render

CLASSES = (*background.CLASSES, *drawing.CLASSES, *render.CLASSES, *batch.CLASSES, *files.CLASSES, *presets.CLASSES)
