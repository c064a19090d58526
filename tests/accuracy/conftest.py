import cv2
import numpy as np
import pytest


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Three small views with masks: two with a line each, one bare. Levels are smooth, so a smooth fill is right."""
    monkeypatch.setenv("PAVEMARK_CACHE", str(tmp_path / "cache"))
    rng = np.random.default_rng(4)
    for folder in ("images", "masks"):
        (tmp_path / folder).mkdir()
    for name in ("a", "b", "bare"):
        image = np.full((80, 100, 3), 100.0) + np.linspace(0, 40, 100)[None, :, None] + rng.normal(0, 1, (80, 100, 3))
        mask = np.zeros((80, 100), np.uint8)
        mask[:, 95:] = 2
        image[:, 95:] = 0
        if name != "bare":
            mask[10:60, 40:44] = 1
            image[mask == 1] = 230
        cv2.imwrite(str(tmp_path / "images" / f"{name}.png"), np.clip(image, 0, 255).astype(np.uint8))
        cv2.imwrite(str(tmp_path / "masks" / f"{name}.png"), mask)
    return tmp_path
