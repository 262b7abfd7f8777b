"""How alike two shapes are, whatever their size, their heading and the way they are meshed.

Shapes stand upright (+y), so that they can differ by a rotation about the vertical axis and a scale. Moments of the
surface that neither changes find candidates among many; the distance between two surfaces, after turning one onto the
other, decides.
"""

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial import cKDTree

from ncmodel.types import Floats, Mesh

SAMPLES = 20_000
"""Points on each surface that stand for it."""

MEASURED = 3_000
"""As many of them are measured against the other surface."""

HEADINGS = 180
"""Directions tried at once, by correlation; the best `PEAKS` are refined."""

PEAKS = 4
HEIGHT_BINS, RADIUS_BINS = 24, 16
REACH = 2.5
"""Extent of the correlated histogram, in root mean square radii."""

# Strang and Fix: weights and barycentric coordinates of six points that integrate polynomials of degree 4 exactly.
_A, _B = 0.445948490915965, 0.091576213509771
_WEIGHTS = np.array([0.223381589678011] * 3 + [0.109951743655322] * 3)
_POINTS = np.array([np.roll([1 - 2 * c, c, c], k) for c in (_A, _B) for k in range(3)])


def invariants(mesh: Mesh) -> Floats:
    """(16,) moments of the surface that scale, heading and meshing leave alone.

    With w = x + i z about the centroid, in units of the root mean square radius: area, and means of y^j |w|^2m w^k up
    to degree 4, of which the size counts where k > 0.
    """
    points, weight = _quadrature(mesh)
    centre, scale = _frame(points, weight)
    x, y, z = ((points - centre) / scale).T
    w = x + 1j * z
    square = (w * w.conj()).real
    terms = [y**2, y**3, y * square, y**4, y**2 * square, square**2]
    turning = [y * w, square * w, y**2 * w, w**2, y * w**2, square * w**2, w**3, y * w**3, w**4]
    upright = [float(np.average(term, weights=weight)) for term in terms]
    sizes = [float(abs(np.average(term, weights=weight))) for term in turning]
    return np.array([float(weight.sum()) / scale**2 / 10, *upright, *sizes])


def surface_distance(one: Mesh, other: Mesh) -> float:
    """Mean distance between two surfaces after the scale and the rotation about y that bring them together best.

    Returns:
        Units of the root mean square radius; from each surface's points to the other surface, averaged.
    """
    points, normals = _samples(one)
    others, other_normals = _samples(other)
    tree, other_tree = cKDTree(points), cKDTree(others)

    def distance(heading: float) -> float:
        forth = _to_surface(_turned(points[:MEASURED], heading), other_tree, others, other_normals)
        back = _to_surface(_turned(others[:MEASURED], -heading), tree, points, normals)
        return (forth + back) / 2

    step = 2 * np.pi / HEADINGS
    best = np.inf
    for heading in _headings(points, others):
        found = minimize_scalar(
            distance, bounds=(heading - step, heading + step), method="bounded", options={"xatol": 1e-4}
        )
        best = min(best, float(found.fun), distance(heading))
    return best


def _samples(mesh: Mesh) -> tuple[Floats, Floats]:
    """Points spread evenly over the surface, about its centroid in units of its radius, and the normals there."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    share = np.cumsum(length) / length.sum()
    rng = np.random.default_rng(0)
    face = np.minimum(np.searchsorted(share, (np.arange(SAMPLES) + rng.random(SAMPLES)) / SAMPLES), len(share) - 1)
    weights = rng.dirichlet((1.0, 1.0, 1.0), SAMPLES)
    points = np.einsum("nk,nkd->nd", weights, corners[face])
    centre, scale = _frame(*_quadrature(mesh))
    # Shuffled, so that the first few are spread evenly too.
    order = rng.permutation(SAMPLES)
    return ((points - centre) / scale)[order], (normal[face] / length[face, None])[order]


def _quadrature(mesh: Mesh) -> tuple[Floats, Floats]:
    """Points on the surface and their weights, by which polynomials up to degree 4 are integrated exactly."""
    corners = mesh.vertices[mesh.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    return np.einsum("qk,fkd->fqd", _POINTS, corners).reshape(-1, 3), (area[:, None] * _WEIGHTS).ravel()


def _frame(points: Floats, weight: Floats) -> tuple[Floats, float]:
    """Centroid and root mean square radius."""
    centre = np.average(points, axis=0, weights=weight)
    return centre, float(np.sqrt(np.average(((points - centre) ** 2).sum(axis=1), weights=weight)))


def _turned(points: Floats, heading: float) -> Floats:
    """Points rotated about y, from +z towards +x."""
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = points.T
    return np.stack([c * x + s * z, y, -s * x + c * z], axis=1)


def _to_surface(points: Floats, tree: cKDTree, samples: Floats, normals: Floats) -> float:
    """Mean distance of points from a sampled surface: along the normal of the nearest sample, no farther than to it."""
    far, nearest = tree.query(points)
    along = np.abs(np.einsum("nd,nd->n", points - samples[nearest], normals[nearest]))
    return float(np.minimum(far, along).mean())


def _headings(points: Floats, others: Floats) -> Floats:
    """The `PEAKS` rotations that bring the points' distribution closest to the others'."""
    one, other = _histogram(points), _histogram(others)
    spectrum = np.fft.rfft(other, axis=-1) * np.fft.rfft(one, axis=-1).conj()
    correlation = np.fft.irfft(spectrum.sum(axis=(0, 1)), HEADINGS)
    neighbours = np.maximum(np.roll(correlation, 1), np.roll(correlation, -1))
    peaks = np.flatnonzero(correlation >= neighbours)
    best = peaks[np.argsort(-correlation[peaks], kind="stable")[:PEAKS]]
    return np.asarray(best * (2 * np.pi / HEADINGS))


def _histogram(points: Floats) -> Floats:
    """(HEIGHT_BINS, RADIUS_BINS, HEADINGS) share of the points in cylindrical bins."""
    x, y, z = points.T
    angle = np.arctan2(x, z) % (2 * np.pi)
    values = np.stack([y, np.hypot(x, z), angle], axis=1)
    ranges = [(-REACH, REACH), (0, REACH), (0, 2 * np.pi)]
    counts: Floats = np.histogramdd(values, (HEIGHT_BINS, RADIUS_BINS, HEADINGS), ranges)[0]
    return counts / len(points)
