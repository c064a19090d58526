"""The four fisheye cameras of a car: where they hang, what their electronics do, how their pictures are joined."""
