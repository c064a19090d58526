"""A small procedural car park seen through four fisheye cameras: the project's own demo images.

Only `stage` imports bpy; everything else is numpy and can be tested without Blender.
"""
