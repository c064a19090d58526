import pytest

from pavemark.background.index import index
from pavemark.errors import InputError


def folder(path, *names):
    path.mkdir()
    for name in names:
        (path / name).touch()
    return path


def test_images_and_masks_meet_by_stem(tmp_path):
    images = folder(tmp_path / "images", "b.JPG", "a.png", "c.webp", "d.txt", ".hidden.png", "e.tif")
    masks = folder(tmp_path / "masks", "a.png", "b.png", "z.png", "c.jpg")
    (images / "f.png").mkdir()
    entries, unmatched = index(images, masks)
    assert [(entry.name, entry.image.name, entry.mask.name) for entry in entries] == [
        ("a", "a.png", "a.png"),
        ("b", "b.JPG", "b.png"),
    ]
    assert [path.name for path in unmatched] == ["c.webp", "e.tif", "z.png"]


def test_without_masks_every_image_counts_in_order_of_name(tmp_path):
    entries, unmatched = index(folder(tmp_path / "images", "b.png", "B.png", "a10.png", "a2.png"))
    assert [entry.name for entry in entries] == ["B", "a10", "a2", "b"]
    assert all(entry.mask is None for entry in entries)
    assert unmatched == ()


def test_files_are_not_opened(tmp_path):
    images = folder(tmp_path / "images")
    (images / "a.png").write_text("not an image, which nobody looks at here")
    assert len(index(images)[0]) == 1


@pytest.mark.parametrize(
    ("names", "told"),
    [
        ((), "holds no image"),
        (("a.txt", ".a.png"), "holds no image"),
        (("a.png", "a.jpg"), "a.png: image has the name of a.jpg"),
    ],
)
def test_folders_that_are_refused(tmp_path, names, told):
    with pytest.raises(InputError, match=told):
        index(folder(tmp_path / "images", *names))


def test_missing_folders_files_and_strangers_are_refused(tmp_path):
    images = folder(tmp_path / "images", "a.png")
    for images_dir, masks_dir, told in (
        (tmp_path / "none", None, "none: cannot be listed: No such file"),
        (folder(tmp_path / "texts", "a.txt") / "a.txt", None, "a.txt: cannot be listed: Not a directory"),
        (images, tmp_path / "none", "none: cannot be listed"),
        (images, folder(tmp_path / "empty"), "holds no PNG mask"),
        (images, folder(tmp_path / "strangers", "b.png"), "no mask has the name of an image"),
    ):
        with pytest.raises(InputError, match=told):
            index(images_dir, masks_dir)


def test_one_image_is_a_list_of_one(tmp_path):
    images, masks = folder(tmp_path / "images", "a.png", "b.png"), folder(tmp_path / "masks", "a.png", "b.png")
    (entry,), unmatched = index(images / "b.png", masks)
    assert (entry.name, entry.image, entry.mask) == ("b", images / "b.png", masks / "b.png")
    assert unmatched == ()
