import numpy as np
import pytest

from pavemark.compose import poisson

# Differences of numbers near 1, solved in float64 on systems of condition below 1e5: rounding stays near 1e-12.
EXACT = 1e-9


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
    "corners": box(30, 40, (0, 6, 0, 6), (0, 6, 34, 40), (24, 30, 0, 6), (24, 30, 34, 40)),
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


def test_a_linear_ramp_goes_on_through_the_domain():
    domain = with_hole()
    v, u = np.mgrid[: domain.shape[0], : domain.shape[1]]
    ramp = (3.0 * u - 2.0 * v)[..., None]
    found = solve(domain, lambda a, b: np.zeros((len(a), 1)), ramp)
    assert np.abs(found - ramp).max() < EXACT * np.abs(ramp).max()


def test_a_shifted_boundary_shifts_the_solution():
    domain = islands()
    rng = np.random.default_rng(2)
    picture = rng.normal(size=(*domain.shape, 1))
    guidance = np.random.default_rng(3).normal(size=(len(poisson.links(domain)[0]), 1))
    first = solve(domain, lambda a, b: guidance, picture)
    second = solve(domain, lambda a, b: guidance, picture + 7.0)
    assert np.abs(second - first - 7.0).max() < EXACT


def test_without_guidance_no_value_passes_those_of_the_boundary(domain):
    boundary = np.random.default_rng(4).normal(size=(*domain.shape, 1))
    inside = solve(domain, lambda a, b: np.zeros((len(a), 1)), boundary)[domain]
    beside = boundary[~domain]
    assert inside.min() >= beside.min() - EXACT
    assert inside.max() <= beside.max() + EXACT


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
