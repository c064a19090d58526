import numpy as np
import pytest

from pavemark.accuracy.holes import LEAST, MARGIN, Move, around, self_made_hole
from pavemark.ground import Frame

FRAME = Frame(120, 90, 30.0)
SHAPE = (90, 120)
RNG = np.random.default_rng(5)


def l_shape(shape=SHAPE, top=30, left=50):
    marking = np.zeros(shape, bool)
    marking[top : top + 30, left : left + 4] = True
    marking[top + 26 : top + 30, left : left + 20] = True
    return marking


def brute_force(shape, bare):
    """The largest area that any shift lays on bare ground, one shift at a time."""
    height, width = shape.shape
    areas = (
        (Move(down=down, right=right).apply(shape, bare.shape) & bare).sum()
        for down in range(1 - height, bare.shape[0])
        for right in range(1 - width, bare.shape[1])
    )
    return max(areas)


def distance(a, b):
    """Least Chebyshev distance between pixels of two masks."""
    p, q = np.argwhere(a), np.argwhere(b)
    return np.abs(p[:, None] - q[None]).max(-1).min()


def test_it_lies_on_bare_ground_and_has_the_marking_s_shape():
    marking, ground = l_shape(), np.ones(SHAPE, bool)
    ground[:, 100:] = False
    hole = self_made_hole(marking, marking, ground, FRAME)
    assert hole.share == 1.0
    assert hole.mask.sum() == around(marking, FRAME).sum()
    assert ground[hole.mask].all()
    # Beyond the soft edge of 4 pixels and the margin of 2 (0.08 m).
    assert distance(hole.mask, marking) > 4 + round(MARGIN * FRAME.scale)
    assert hole.keep_out[marking].all()
    assert hole.keep_out[~ground].all()
    assert not (hole.keep_out & hole.mask).any()
    back = hole.move.apply(around(marking, FRAME), SHAPE)
    assert np.array_equal(back, hole.mask)


def test_of_all_shifts_it_is_the_one_with_most_room():
    small = Frame(30, 24, 10.0)
    marking = np.zeros((24, 30), bool)
    marking[3:20, 13:15] = True
    ground = RNG.random((24, 30)) < 0.9
    hole = self_made_hole(marking, marking, ground, small)
    bare = ground & ~around(around(marking, small), Frame(30, 24, 1.0))
    # The margin is one pixel here, the soft edge two: widened three in all.
    wide = np.zeros((24, 30), bool)
    wide[0:23, 10:18] = True
    bare = ground & ~wide
    shape = around(marking, small)
    turned = [np.rot90(shape[:, ::step], quarters) for step in (1, -1) for quarters in range(4)]
    tried = [brute_force(one, bare) for one in turned]
    assert hole.mask.sum() == max(tried)
    assert hole.share == pytest.approx(max(tried) / shape.sum())


def test_it_is_turned_only_where_a_shift_finds_too_little_room():
    ground = np.zeros(SHAPE, bool)
    ground[:30] = True
    line = np.zeros(SHAPE, bool)
    line[:, 60:64] = True
    hole = self_made_hole(line, np.zeros(SHAPE, bool), ground, FRAME)
    assert hole.move.quarters % 2 == 1
    assert hole.share == 1.0
    ground[:] = True
    hole = self_made_hole(line, line, ground, FRAME)
    assert (hole.move.quarters, hole.move.mirrored) == (0, False)


def test_a_marking_of_another_image_may_be_of_another_size():
    borrowed = l_shape((60, 200), 10, 150)
    hole = self_made_hole(borrowed, np.zeros(SHAPE, bool), np.ones(SHAPE, bool), FRAME)
    assert hole.share == 1.0
    assert hole.mask.shape == SHAPE


def test_the_same_input_gives_the_same_hole():
    marking, ground = l_shape(), RNG.random(SHAPE) < 0.97
    first, second = (self_made_hole(marking, marking, ground, FRAME) for _ in range(2))
    assert first.move == second.move
    assert np.array_equal(first.mask, second.mask)


@pytest.mark.parametrize("lacking", ["ground", "marking", "room"])
def test_no_hole_where_there_is_no_room_for_one(lacking):
    marking, ground = l_shape(), np.ones(SHAPE, bool)
    if lacking == "ground":
        ground[:] = False
    elif lacking == "marking":
        marking[:] = False
    else:
        # A strip that the hole fills to more than half.
        ground[:] = False
        ground[:7, :17] = True
    assert self_made_hole(marking, marking, ground, FRAME) is None


def test_a_hole_never_takes_more_than_half_of_the_bare_ground():
    marking, ground = np.ones((40, 40), bool), np.zeros(SHAPE, bool)
    ground[:20, :20] = True
    hole = self_made_hole(marking, np.zeros(SHAPE, bool), ground, FRAME)
    assert LEAST <= hole.mask.sum() <= 200


def test_moves_mirror_then_turn_then_shift():
    array = np.array([[1, 2, 3], [4, 5, 6]])
    assert np.array_equal(Move(mirrored=True).apply(array, (2, 3)), [[3, 2, 1], [6, 5, 4]])
    assert np.array_equal(Move(quarters=1).apply(array, (3, 2)), [[3, 6], [2, 5], [1, 4]])
    assert np.array_equal(Move(mirrored=True, quarters=1).apply(array, (3, 2)), [[1, 4], [2, 5], [3, 6]])
    assert np.array_equal(Move(down=-1, right=2).apply(array, (2, 4)), [[0, 0, 4, 5], [0, 0, 0, 0]])
    assert not Move(down=5).apply(array, (2, 3)).any()
    assert Move(right=1).apply(np.ones((2, 2, 3)), (2, 2)).sum() == 6
