"""Pavemark: synthetic around-view-monitor images with exact parking-slot labels.

Everything outside Blender. Nothing in this package imports ``bpy``.
"""

__version__ = "0.1.0"
