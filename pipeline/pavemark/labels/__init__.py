"""Labels from the scene: the truth, and one writer a file for each format."""
