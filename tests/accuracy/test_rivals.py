"""Rivals of our Poisson solver: each is held against it, and against what the mathematics says of it."""

import numpy as np
import pytest

from pavemark.accuracy import rivals
from pavemark.accuracy.blend import ALPHA, BLOCK, CLONE, ROW, errors, problem, ways
from pavemark.accuracy.rivals import iterative, multigrid, product, refined, whole
from pavemark.compose import poisson
from pavemark.compose.blend import lit
from pavemark.ground import Frame

SMALL = Frame(150, 150, 15)


def disc(size, radius):
    v, u = np.mgrid[:size, :size]
    middle = (size - 1) / 2
    return (v - middle) ** 2 + (u - middle) ** 2 <= radius**2


DOMAINS = {
    "one pixel": np.pad(np.ones((1, 1), bool), 4),
    "a line": np.pad(np.ones((3, 60), bool), 5),
    "a ring": disc(60, 25) & ~disc(60, 9),
    "a corner of the picture": np.pad(np.ones((20, 30), bool), ((0, 9), (0, 9))),
}


@pytest.fixture(params=DOMAINS, ids=DOMAINS)
def equation(request):
    domain = DOMAINS[request.param]
    rng = np.random.default_rng(3)
    a, b = poisson.links(domain)
    return domain, a, b, rng.normal(size=(len(a), 3)), rng.normal(size=(*domain.shape, 3))


def backward_error(equations, change):
    """Rigal and Gaches (1967), the largest of the channels: how little the equations must change to be met exactly."""
    left = equations.source - equations.matrix @ change
    # No row of the matrix sums to more than 8 in absolute values.
    size = 8 * np.linalg.norm(change, axis=0) + np.linalg.norm(equations.source, axis=0)
    return (np.linalg.norm(left, axis=0) / size).max()


@pytest.mark.parametrize("preconditioner", [None, multigrid])
@pytest.mark.parametrize("tolerance", [1e-1, 1e-4, 1e-10])
def test_iterations_end_within_their_tolerance(equation, tolerance, preconditioner):
    equations = poisson.system(*equation)
    found = iterative(*equation, tolerance, preconditioner)
    change = found - equation[4][equation[0]]
    assert backward_error(equations, change) <= tolerance
    if tolerance == 1e-10:
        # Condition of these systems: below 1e3.
        assert np.abs(found - poisson.solve(*equation)).max() < 1e-6


def test_iterations_that_do_not_end_raise_and_say_how_far_they_came():
    domain = DOMAINS["a ring"]
    a, b = poisson.links(domain)
    rng = np.random.default_rng(0)
    guidance, boundary = rng.normal(size=(len(a), 1)), rng.normal(size=(*domain.shape, 1))
    with pytest.raises(np.linalg.LinAlgError, match=r"did not converge: residual .*e-0\d .* after 5 iterations"):
        iterative(domain, a, b, guidance, boundary, 1e-10, limit=5)
    iterative(domain, a, b, guidance, boundary, 1e-10, multigrid, limit=20)


def test_the_whole_factor_is_our_solution(equation):
    assert np.abs(whole(*equation) - poisson.solve(*equation)).max() < 1e-11


def test_the_matrix_is_the_product(equation):
    equations = poisson.system(*equation)
    vector = np.random.default_rng(1).normal(size=equations.source.shape)
    matrix = equations.matrix
    assert (matrix != matrix.T).nnz == 0
    assert np.allclose(product(equations, vector), matrix @ vector, rtol=0, atol=1e-13)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long double is no longer than double here")
def test_the_reference_is_far_more_exact_than_what_is_judged():
    of = problem(ROW, SMALL)
    equations = poisson.system(*of.equation)
    given = of.asked.boundary[of.asked.domain]

    def residual(solved):
        return np.linalg.norm(equations.source - product(equations, solved - given))

    ours = poisson.solve(*of.equation).astype(np.longdouble)
    assert residual(refined(*of.equation)) < 1e-2 * residual(ours)


def test_sine_transforms_are_exact_on_a_rectangle_and_leak_beside_a_disc():
    rng = np.random.default_rng(2)
    for domain, exact in ((np.pad(np.ones((21, 34), bool), 3), True), (disc(50, 15), False)):
        a, b = poisson.links(domain)
        guidance, boundary = rng.normal(size=(len(a), 2)), rng.normal(size=(*domain.shape, 2))
        found = rivals.fast(domain, a, b, guidance, boundary)
        off = np.abs(found[domain] - poisson.solve(domain, a, b, guidance, boundary)).max()
        beside = np.abs(found - boundary)[~domain].max()
        assert (off < 1e-11, beside == 0.0) == (exact, exact)


@pytest.mark.parametrize("name", [ROW, BLOCK])
def test_the_order_of_the_contenders_is_known(name):
    of = problem(name, SMALL)
    tolerances = (1e-1, 1e-4, 1e-8)
    made = {}
    for way, solve in ways(tolerances).items():
        made[way] = errors(solve(of), of, way[0] in (ALPHA, CLONE))
    for family in ("conjugate gradients", "conjugate gradients with multigrid"):
        loose, middle, tight = (made[family, f"1e-{k}"] for k in (1, 4, 8))
        assert loose["error"] > 10 * middle["error"] > 100 * tight["error"]
        assert loose["residual"] <= 1e-1 and middle["residual"] <= 1e-4 and tight["residual"] <= 1e-8
    assert made["direct", ""]["error"] < 1e-9 < 1e-3 < made[ALPHA, ""]["error"]
    # Only what cannot keep to the domain changes what lies beside it.
    beside = {way[0] for way, one in made.items() if one["outside_worst"] > 0}
    assert beside == ({"sine transform", CLONE} if name == ROW else {"sine transform"})


def test_an_error_is_in_levels_and_a_change_outside_is_counted():
    of = problem(BLOCK, SMALL)
    solved = poisson.solve(*of.equation)
    picture = of.plate.image.astype(float)
    picture[of.asked.domain] = np.clip(np.rint(lit(solved)), 0, 255)
    picture[:2, :5] += 3
    told = errors(picture, of, True)
    assert 0.4 < told["error"] <= 0.5
    assert (told["outside"], told["outside_worst"]) == (10, 3.0)
