"""Poisson's equation on domains of every awkward shape, and on pictures of the strongest contrast."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from hard_cases import EPS, STEADY
from pavemark.accuracy.rivals import iterative
from pavemark.colour import LINEAR, quantise, to_display
from pavemark.compose import blend, poisson
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.scene import Blend
from scenes import plate

EXACT = 1e-9
"""Differences of numbers near 1, solved in float64 on systems of condition below 1e5: rounding stays near 1e-12."""

METHODS = ("reflectance", "normal", "mixed", "alpha")


def disc(height, width, centre, radius):
    v, u = np.mgrid[:height, :width]
    return (v - centre[0]) ** 2 + (u - centre[1]) ** 2 <= radius**2


def box(height, width, *boxes):
    domain = np.zeros((height, width), bool)
    for top, bottom, left, right in boxes:
        domain[top:bottom, left:right] = True
    return domain


def with_hole():
    return disc(40, 50, (20, 25), 15) & ~disc(40, 50, (18, 22), 4)


def islands():
    return box(40, 50, (2, 9, 2, 9), (15, 16, 5, 45), (20, 21, 10, 11), (25, 38, 30, 48))


DOMAINS = {
    "empty": np.zeros((9, 9), bool),
    "one pixel": box(9, 9, (4, 5, 4, 5)),
    "one dark pixel of the chessboard": box(9, 9, (4, 5, 5, 6)),
    "one pixel wide": box(20, 30, (7, 8, 3, 27)),
    "disc": disc(40, 50, (20, 25), 12),
    "hole": with_hole(),
    "islands": islands(),
    "diagonal": np.eye(30, dtype=bool) | np.eye(30, k=1, dtype=bool),
    "top": box(30, 40, (0, 5, 10, 20)),
    "bottom": box(30, 40, (25, 30, 10, 20)),
    "left": box(30, 40, (10, 20, 0, 5)),
    "right": box(30, 40, (10, 20, 35, 40)),
    "corner, upper left": box(30, 40, (0, 6, 0, 7)),
    "corner, upper right": box(30, 40, (0, 6, 33, 40)),
    "corner, lower left": box(30, 40, (24, 30, 0, 7)),
    "corner, lower right": box(30, 40, (24, 30, 33, 40)),
    "a pixel in each corner": box(30, 40, (0, 1, 0, 1), (0, 1, 39, 40), (29, 30, 0, 1), (29, 30, 39, 40)),
    "along all borders": ~box(30, 40, (1, 29, 1, 39)),
    "across, from border to border": box(30, 40, (14, 15, 0, 40)),
    "all but one pixel": ~box(30, 40, (11, 12, 17, 18)),
}


@pytest.fixture(params=DOMAINS, ids=DOMAINS)
def domain(request):
    return DOMAINS[request.param]


def solve(domain, guidance, boundary):
    """The whole picture (H, W, C), from guidance given as a function of the links."""
    a, b = poisson.links(domain)
    picture = boundary.copy()
    picture[domain] = poisson.solve(domain, a, b, guidance(a, b), np.where(domain[..., None], 1e3, boundary))
    return picture


def gradient_of(picture):
    flat = picture.reshape(-1, picture.shape[2])
    return lambda a, b: flat[b] - flat[a]


def test_links_are_the_neighbours_of_the_domain(domain):
    height, width = domain.shape
    wanted = set()
    for v in range(height):
        for u in range(width):
            for dv, du in ((0, 1), (1, 0)):
                if v + dv < height and u + du < width and (domain[v, u] or domain[v + dv, u + du]):
                    wanted.add((v * width + u, (v + dv) * width + u + du))
    a, b = poisson.links(domain)
    assert len(a) == len(wanted)
    assert set(zip(a.tolist(), b.tolist(), strict=True)) == wanted


def test_a_picture_is_found_again_from_its_gradient(domain):
    rng = np.random.default_rng(0)
    picture = rng.normal(size=(*domain.shape, 3))
    assert np.abs(solve(domain, gradient_of(picture), picture) - picture).max() < EXACT


def test_every_equation_holds_for_any_guidance(domain):
    """Residual written out pixel by pixel, with no link where the picture ends."""
    rng = np.random.default_rng(1)
    height, width = domain.shape
    right = rng.normal(size=(height, width, 2))
    down = rng.normal(size=(height, width, 2))

    def guidance(a, b):
        across = (b == a + 1)[:, None]
        return np.where(across, right.reshape(-1, 2)[a], down.reshape(-1, 2)[a])

    f = solve(domain, guidance, rng.normal(size=(height, width, 2)))
    for v, u in np.argwhere(domain):
        residual = np.zeros(2)
        if u > 0:
            residual += f[v, u] - f[v, u - 1] - right[v, u - 1]
        if v > 0:
            residual += f[v, u] - f[v - 1, u] - down[v - 1, u]
        if u < width - 1:
            residual -= f[v, u + 1] - f[v, u] - right[v, u]
        if v < height - 1:
            residual -= f[v + 1, u] - f[v, u] - down[v, u]
        assert np.abs(residual).max() < EXACT


def ramp(domain):
    v, u = np.indices(domain.shape)
    return np.stack([3.0 * u - 2.0 * v, 0.1 * u + 0.7 * v - 40], -1)


def test_a_linear_ramp_is_reproduced(domain):
    wanted = ramp(domain)
    # Its gradient is asked for; numbers up to 200.
    assert np.abs(solve(domain, gradient_of(wanted), wanted) - wanted).max() < EXACT * 200


def test_a_linear_ramp_goes_on_through_the_domain(domain):
    """Without guidance, where no border of the picture adds a condition: a ramp is harmonic, to the last digit."""
    inner = np.pad(domain, 1)
    wanted = ramp(inner)
    found = solve(inner, lambda a, b: np.zeros((len(a), 2)), wanted)
    assert np.abs(found - wanted).max() < EXACT * 200


def test_a_constant_added_to_the_source_moves_nothing(domain):
    rng = np.random.default_rng(2)
    source, boundary = rng.integers(0, 256, (2, *domain.shape, 3)).astype(np.float64)
    # Whole numbers: the gradients are the same to the bit, and so is all that follows.
    np.testing.assert_array_equal(
        solve(domain, gradient_of(source + 64.0), boundary), solve(domain, gradient_of(source), boundary)
    )


def test_a_constant_added_to_the_boundary_moves_all_by_it(domain):
    rng = np.random.default_rng(2)
    picture = rng.normal(size=(*domain.shape, 1))
    guidance = rng.normal(size=(len(poisson.links(domain)[0]), 1))
    first, second = (solve(domain, lambda a, b: guidance, picture + shift) for shift in (0.0, 7.0))
    assert np.abs(second - first - 7.0).max() < EXACT * 7


def test_without_guidance_no_value_passes_those_of_the_boundary(domain):
    boundary = np.random.default_rng(4).normal(size=(*domain.shape, 1))
    inside = solve(domain, lambda a, b: np.zeros((len(a), 1)), boundary)[domain]
    beside = boundary[~domain]
    # The maximum principle: every pixel is the mean of its neighbours.
    assert ((inside >= beside.min() - EXACT) & (inside <= beside.max() + EXACT)).all()


def chessboard(shape, channels=1):
    return np.repeat(255.0 * (np.indices(shape).sum(0) % 2)[..., None], channels, -1)


def test_a_chessboard_of_0_and_255_is_found_again(domain):
    board = chessboard(domain.shape, 3)
    assert np.abs(solve(domain, gradient_of(board), board) - board).max() < EXACT * 255


def test_beside_a_chessboard_of_0_and_255_nothing_passes_them(domain):
    board = chessboard(domain.shape)
    inside = solve(domain, lambda a, b: np.zeros((len(a), 1)), board)[domain]
    assert ((inside > -EXACT * 255) & (inside < 255 * (1 + EXACT))).all()


def test_the_opposite_of_a_chessboard_stays_within_what_it_asks_for(domain):
    """The board's own gradient turned round, on the board: the strongest guidance there is, against the boundary."""
    board = chessboard(domain.shape)
    found = solve(domain, lambda a, b: -gradient_of(board)(a, b), board)
    # f = 255 - board + h with h harmonic and, beside the domain, 2·board - 255 = ±255: so f lies within -255 and 510.
    assert ((found >= -255 - EXACT * 255) & (found <= 510 * (1 + EXACT))).all()


def decals(alpha, colour):
    alpha = np.asarray(alpha, np.float64)[..., None]
    return Layers(np.concatenate([alpha * colour, alpha], -1).astype(np.float32))


def colour_of(method):
    return np.array((2.2, 2.1, 1.9)) if method == "reflectance" else LINEAR[[225, 220, 190]]


@pytest.mark.parametrize("edge_blur", [False, True], ids=["sharp", "blurred"])
@pytest.mark.parametrize("cell", [1, 2, 7])
@pytest.mark.parametrize("method", METHODS)
def test_paint_on_a_chessboard_of_0_and_255_stays_within_8_bits(method, cell, edge_blur):
    on = plate(Frame(80, 80))
    on.image[:] = 255 * (np.indices((80, 80)) // cell).sum(0)[..., None] % 510
    assert set(np.unique(on.image)) == {0, 255}
    alpha = np.zeros((80, 80))
    alpha[30:44, 6:80] = alpha[0:70, 50:53] = 1
    alpha[60:64] = 0.5
    found = blend.apply(on, decals(alpha, colour_of(method)), Blend(method=method, edge_blur=edge_blur))
    assert np.isfinite(found).all()
    # No overflow, and nothing left for rounding to cut off: float32 is exact to 1.5e-5 at 255.
    assert found.min() >= 0 and found.max() <= 255 * (1 + 2**-23)
    far = np.ones((80, 80), bool)
    far[24:50] = far[:76, 44:59] = far[54:70] = False
    np.testing.assert_array_equal(found[far], on.image[far])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tone", [0, 1, 254, 255])
def test_paint_on_black_and_on_white_stays_within_8_bits(method, tone):
    alpha = np.zeros((40, 40))
    alpha[10:16] = 1
    for colour in (np.zeros(3), colour_of(method), np.ones(3) * (100 if method == "reflectance" else 1)):
        found = blend.apply(plate(Frame(40, 40), tone), decals(alpha, colour), Blend(method=method))
        assert np.isfinite(found).all()
        assert found.min() >= 0 and found.max() <= 255 * (1 + 2**-23)


@pytest.mark.parametrize("method", METHODS)
def test_domain_full_paint_all_over_is_the_plain_composite(method):
    on, colour = plate(Frame(40, 40), 120), colour_of(method)
    found = quantise(blend.apply(on, decals(np.ones((40, 40)), colour), Blend(method=method)))
    asked = LINEAR[120] * colour if method == "reflectance" else colour
    # There is no boundary to solve from. Float32 decals and one rounding: at most one level.
    assert np.abs(found - to_display(asked)).max() <= 1


@pytest.mark.parametrize("method", METHODS)
def test_domain_empty_no_paint_is_the_plate(method):
    on = plate(Frame(40, 40), 120, texture=20)
    found = blend.apply(on, decals(np.zeros((40, 40)), np.ones(3)), Blend(method=method))
    np.testing.assert_array_equal(found, on.image)


@settings(STEADY, max_examples=150)
@given(
    arrays(bool, array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12)),
    st.integers(0, 2**32 - 1),
    st.integers(-3, 6),
)
def test_any_domain_is_solved_as_exactly_as_its_numbers_are(domain, seed, power):
    if domain.all():
        domain.flat[0] = False
    rng = np.random.default_rng(seed)
    a, b = poisson.links(domain)
    boundary = 10.0**power * rng.normal(size=(*domain.shape, 2))
    guidance = 10.0**power * rng.normal(size=(len(a), 2))
    f = boundary.reshape(-1, 2).copy()
    f[domain.reshape(-1)] = poisson.solve(domain, a, b, guidance, boundary)
    # Backward error: what the equations lack is rounding of their own terms, at most 4 links of at most f and v, with
    # as many products in a row of the factor as the domain is wide at most, 144 here.
    lack = f[b] - f[a] - guidance
    sums = np.zeros_like(f)
    np.add.at(sums, b, lack)
    np.add.at(sums, a, -lack)
    largest = 8 * np.abs(f).max() + 4 * np.abs(guidance).max(initial=0)
    assert np.abs(sums[domain.reshape(-1)]).max(initial=0) <= 144 * EPS * largest
    # And the least-squares solution by a dense solver, orthogonal and so of another kind.
    unknown = np.flatnonzero(domain)
    matrix = np.zeros((len(a), domain.size))
    matrix[np.arange(len(a)), b] += 1
    matrix[np.arange(len(a)), a] -= 1
    known = np.where(domain.reshape(-1)[:, None], 0, f)
    dense = np.linalg.lstsq(matrix[:, unknown], guidance - matrix @ known, rcond=None)[0]
    assert np.abs(f[unknown] - dense).max(initial=0) < EXACT * 10.0**power


def test_wide_domains_are_solved_as_exactly_as_narrow_ones(monkeypatch):
    domain = disc(90, 90, (45, 45), 40)
    rng = np.random.default_rng(5)
    picture = rng.normal(size=(*domain.shape, 3))
    monkeypatch.setattr(poisson, "WIDEST_BAND", 8)
    assert np.abs(solve(domain, gradient_of(picture), picture) - picture).max() < EXACT


def test_a_domain_without_boundary_is_refused():
    domain = np.ones((9, 9), bool)
    a, b = poisson.links(domain)
    with pytest.raises(ValueError, match="no boundary"):
        poisson.solve(domain, a, b, np.zeros((len(a), 1)), np.zeros((9, 9, 1)))


def test_memory_stays_over_many_calls():
    resource = pytest.importorskip("resource")
    domain = islands()
    a, b = poisson.links(domain)
    guidance, boundary = np.ones((len(a), 3)), np.zeros((*domain.shape, 3))

    def run(count):
        for _ in range(count):
            poisson.solve(domain, a, b, guidance, boundary)
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = run(100)
    # Kilobytes. One leaked band of this domain, 10 kB a call, would add 10 MB.
    assert run(1000) - before < 4000


@pytest.mark.parametrize("name", [name for name in DOMAINS if name != "empty"])
def test_iterative_equals_direct_to_its_tolerance(name):
    domain = DOMAINS[name]
    rng = np.random.default_rng(5)
    a, b = poisson.links(domain)
    equation = domain, a, b, rng.normal(size=(len(a), 3)), rng.normal(size=(*domain.shape, 3))
    direct = poisson.solve(*equation)
    for tolerance in (1e-4, 1e-10):
        # A residual of that share of the right side, times the norm of the inverse: 1 over the least eigenvalue.
        system = poisson.system(*equation)
        least = np.linalg.eigvalsh(system.matrix.toarray())[0]
        bound = tolerance * np.linalg.norm(system.source, axis=0).max() / least
        assert np.abs(iterative(*equation, tolerance) - direct).max() <= bound + EXACT


def test_iterations_that_do_not_converge_raise():
    domain = DOMAINS["disc"]
    rng = np.random.default_rng(5)
    a, b = poisson.links(domain)
    with pytest.raises(np.linalg.LinAlgError, match="did not converge"):
        iterative(domain, a, b, rng.normal(size=(len(a), 1)), rng.normal(size=(*domain.shape, 1)), 1e-12, limit=3)
