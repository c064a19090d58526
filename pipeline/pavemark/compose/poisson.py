"""Poisson's equation on the pixels of a domain, solved exactly.

Find f with f(b) - f(a) = v(a, b) along every link of neighbouring pixels, in the least-squares sense, where f is given
outside the domain (Pérez, Gangnet, Blake, *Poisson image editing*, 2003, Eq. 7). At the picture's border there is no
link, which is the natural (Neumann) condition on that side.
"""

from __future__ import annotations

import attrs
import numpy as np
import scipy.linalg
import scipy.sparse as sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

WIDEST_BAND = 256
"""Half-width above which the band's Cholesky factor is slower and larger than a general sparse one."""


def links(domain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of neighbouring pixels of which at least one is in the domain.

    Parameters
    ----------
    domain : ndarray (H, W) bool

    Returns
    -------
    a, b : ndarray (L,) int32
        Flat (row-major) pixel indices; b lies right of a or below it.
    """
    width = domain.shape[1]
    across = np.flatnonzero(np.pad(domain[:, :-1] | domain[:, 1:], ((0, 0), (0, 1))))
    down = np.flatnonzero(domain[:-1] | domain[1:])
    a = np.concatenate([across, down]).astype(np.int32)
    b = np.concatenate([across + 1, down + width]).astype(np.int32)
    return a, b


@attrs.frozen(eq=False)
class System:
    """The normal equations of Poisson's equation, for f - boundary, which is nought beside the domain.

    Attributes
    ----------
    pixels : ndarray (N,) int
        Flat indices of the domain's pixels in row-major order: the unknowns.
    degree : ndarray (N,) int
        Links of each unknown.
    start, end : ndarray (M,) int32
        Numbers of the unknowns that a link joins, of the links with both ends in the domain.
    source : ndarray (N, C) float64
        Right sides, a column a channel.
    """

    pixels: np.ndarray
    degree: np.ndarray
    start: np.ndarray
    end: np.ndarray
    source: np.ndarray

    @property
    def matrix(self) -> sparse.csr_matrix:
        """The five-point matrix (N, N) float64: symmetric, and positive definite where every part has a boundary."""
        count = len(self.pixels)
        every, less = np.arange(count), np.full(len(self.start), -1.0)
        rows, columns = (
            np.concatenate(ends) for ends in ((every, self.start, self.end), (every, self.end, self.start))
        )
        return sparse.csr_matrix((np.concatenate([self.degree, less, less]), (rows, columns)), (count, count))


def system(domain: np.ndarray, a: np.ndarray, b: np.ndarray, guidance: np.ndarray, boundary: np.ndarray) -> System:
    """The equations that `solve` solves, from what it is given.

    Raises
    ------
    ValueError
        When the domain is the whole picture: f is then free up to a constant.
    """
    if domain.all():
        raise ValueError("the domain covers the whole picture and leaves no boundary")
    pixels = np.flatnonzero(domain)
    number = np.full(domain.size, -1, np.int32)
    number[pixels] = np.arange(len(pixels), dtype=np.int32)
    start, end = number[a], number[b]
    degree = _sum(start, len(pixels)) + _sum(end, len(pixels))
    given = boundary.reshape(domain.size, -1)
    change = guidance - (given[b] - given[a])
    source = np.stack([_sum(end, len(pixels), v) - _sum(start, len(pixels), v) for v in change.T], axis=-1)
    inside = (start >= 0) & (end >= 0)
    return System(pixels, degree, start[inside], end[inside], source)


def solve(domain: np.ndarray, a: np.ndarray, b: np.ndarray, guidance: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """Solve Poisson's equation with Dirichlet boundary on the pixels of a domain alone.

    The pixels are coloured like a chessboard and those of one colour are eliminated by hand, which halves the system;
    the rest, long strips a few pixels wide, is a narrow band in reverse Cuthill-McKee order. One factor serves all
    channels.

    Parameters
    ----------
    domain : ndarray (H, W) bool
        Where f is unknown; any number of parts, with holes, touching any border.
    a, b : ndarray (L,) int
        `links(domain)`.
    guidance : ndarray (L, C) float64
        The wanted f(b) - f(a).
    boundary : ndarray (H, W, C) float64
        f beside the domain; inside it any finite values, which do not matter.

    Returns
    -------
    ndarray (N, C) float64
        f at the pixels of the domain in row-major order.

    Raises
    ------
    ValueError
        When the domain is the whole picture: f is then free up to a constant.
    """
    equations = system(domain, a, b, guidance, boundary)
    row, column = np.divmod(equations.pixels, domain.shape[1])
    light = (row + column) % 2 == 0
    given = boundary.reshape(domain.size, -1)
    return given[equations.pixels] + _halved(light, equations.degree, equations.start, equations.end, equations.source)


def _sum(at: np.ndarray, count: int, values: np.ndarray | None = None) -> np.ndarray:
    """Values (default 1) added up by number; a negative number is nowhere."""
    return np.bincount(at + 1, values, count + 1)[1:]


def _halved(
    light: np.ndarray, degree: np.ndarray, start: np.ndarray, end: np.ndarray, source: np.ndarray
) -> np.ndarray:
    """Solve for the light squares of the chessboard, then read the dark ones off their neighbours."""
    within = np.where(light, np.cumsum(light), np.cumsum(~light)) - 1
    start_light = light[start]
    lights = within[np.where(start_light, start, end)]
    darks = within[np.where(start_light, end, start)]
    shape = (int(light.sum()), int((~light).sum()))
    touch = sparse.csr_matrix((np.ones(len(lights)), (lights, darks)), shape)
    by_degree = 1 / degree[~light]

    result = np.empty_like(source)
    if shape[0]:
        scaled = touch @ sparse.diags(by_degree)
        matrix = (sparse.diags(degree[light].astype(np.float64)) - scaled @ touch.T).tocsr()
        result[light] = _definite(matrix, source[light] + scaled @ source[~light])
    result[~light] = by_degree[:, None] * (source[~light] + touch.T @ result[light])
    return result


def _definite(matrix: sparse.csr_matrix, right: np.ndarray) -> np.ndarray:
    """Solve a sparse symmetric positive definite system (n, n) for right sides (n, C)."""
    count = len(right)
    order = reverse_cuthill_mckee(matrix, symmetric_mode=True)
    place = np.empty(count, np.int64)
    place[order] = np.arange(count)
    entries = matrix.tocoo()
    row, column = place[entries.row], place[entries.col]
    width = int((row - column).max())
    if width > WIDEST_BAND:
        options = {"SymmetricMode": True}
        factor = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        return factor.solve(right)
    lower = row >= column
    band = np.zeros((width + 1, count), order="F")
    band[(row - column)[lower], column[lower]] = entries.data[lower]
    solved = scipy.linalg.solveh_banded(
        band, right[order], overwrite_ab=True, overwrite_b=True, lower=True, check_finite=False
    )
    return solved[place]
