"""The only code that imports bpy: the stage that the add-on and render.py share."""
