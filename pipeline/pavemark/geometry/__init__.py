"""The scene's geometry as it lies on the ground: elastic field, outlines of the paint, exact coverage."""
