"""The camera that a drawing was seen from, found by the drawing's outline.

From several starts over the view sphere, the mesh's outline is laid over the drawn one: points of the mesh's rim, taken
as fixed on it, are moved onto the drawn outline by least squares on signed distances, both ways; then the rim is found
anew. To first order it doesn't matter that the rim slides over the surface meanwhile, since it slides along rays that
touch the surface. Small pictures come first, the drawing's own size last.

Shapes with a mirror plane look nearly alike from above in front and from below behind. Poses that fit the outline about
equally well are told apart by the lines inside it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from eval.measures.metrics import f1_score
from eval.measures.thinning import thin_lines
from eval.people.outline import DrawnOutline, SeenOutline, seen_outline
from eval.people.poses import FARTHEST, NEAREST, Pose, starting_poses
from ncmodel.camera import Camera
from ncmodel.chamfer import Lines, diagonal
from ncmodel.drawing.draw import draw
from ncmodel.geometry.raycast import RayScene
from ncmodel.types import Floats, Image, Mesh

UPRIGHT = math.radians(30.0)
"""How far +y may lean to the side in the picture in what is tried first; all rolls come after."""

STARTS = 24
_SIDES = (128, 288)
"""Longer side of the small pictures that come first."""
_ROUNDS = (10, 6, 8)
"""How often the rim is found anew in each size."""
_KEPT = 6
"""Starts that go on to the second size."""
_POINTS = 1000
"""Of an outline, each way, spread evenly: more tell no more."""
_OUTLIER = 0.003
"""Share of the picture's diagonal from which on a point's distance counts for less than its square."""
_REACH = 6.0
"""In units of that: points of the drawn outline so far from the mesh's are a part that it hasn't, or not yet."""
_SETTLED = 1e-4
"""Least change of a pose, in radians or logarithms, for which the rim is found anew."""
_STEPS = 2
"""Between two rims."""
_DAMPING = 1e-3
_LOOSE = 1e-4
"""Of a step, as a share of what residuals tell about it, and in units of the object's size."""
_FARTHEST_STEP = 0.3
"""Radians, or logarithms, or shares of the object's size."""

_AXES = np.eye(7)
_AXES_OF_KNOWN_FOCAL = np.vstack([np.eye(6), [[0.0, 0.0, 0.0, 0.0, 0.0, -1.0]]])
"""What moves freely: with a known focal length, what is larger is nearer."""

_ALIKE = 1.5
"""Outlines whose distances differ by less than this factor, or `_ALIKE_PIXELS`, fit about equally well."""
_ALIKE_PIXELS = 0.3
_DIFFERENT = math.radians(5.0)

FARTHEST_OUTLINE = 0.02
"""Share of the outline's own size: if the outlines are farther from each other in the mean, no pose fits."""
LEAST_OVERLAP = 0.85


class NoPoseError(ValueError):
    """No pose of the mesh has the drawing's outline."""


@dataclass(frozen=True, eq=False)
class CameraFit:
    """A camera found for a drawing.

    Attributes:
        camera: It, of the drawing's size.
        outline_distance: Mean distance between the mesh's outline and the drawn one, both ways; pixels.
        overlap: Intersection over union of what the two enclose.
        starts: Poses that were begun from.
        rivals: Other views whose outline fits about as well, told apart by the lines inside.
        seen: The mesh's outline through the camera.
    """

    camera: Camera
    outline_distance: float
    overlap: float
    starts: int
    rivals: int
    seen: SeenOutline


def fit_camera(
    mesh: Mesh, ink: Image, outline: DrawnOutline, focal_pixels: float | None = None, starts: int = STARTS
) -> CameraFit:
    """Find where a drawing of a mesh was seen from.

    Args:
        mesh: The mesh, in object space.
        ink: (H, W) the drawing, 1 = line; what is inside the outline tells poses apart that fit it equally well.
        outline: The drawing's outline.
        focal_pixels: The focal length if it is known; otherwise it is found, too.
        starts: Poses to begin from.

    Raises:
        NoPoseError: None fits.
    """
    scene = RayScene(mesh)
    best: CameraFit | None = None
    for lean in (UPRIGHT, math.pi):
        found = _fit(scene, mesh, ink, outline, focal_pixels, starts, lean)
        best = found if best is None or found.outline_distance < best.outline_distance else best
        if _fits(best, outline):
            return best
    assert best is not None
    raise NoPoseError(
        f"no pose of the mesh has its outline: the best lies {best.outline_distance:.1f} pixels from it, "
        f"overlap {best.overlap:.2f}"
    )


def _fit(
    scene: RayScene,
    mesh: Mesh,
    ink: Image,
    outline: DrawnOutline,
    focal_pixels: float | None,
    starts: int,
    lean: float,
) -> CameraFit:
    height, width = outline.region.shape
    poses = starting_poses(scene, outline.region, starts, lean)
    placed = [_Placed(pose, math.inf) for pose in poses]
    for side, rounds, keep in zip(_SIDES, _ROUNDS, (_KEPT, _KEPT), strict=False):
        factor = min(1.0, side / max(width, height))
        small = outline.shrunk(max(1, round(width * factor)), max(1, round(height * factor)))
        known = None if focal_pixels is None else focal_pixels * factor
        placed = [_refined(scene, small, p.pose.scaled(factor), rounds, known) for p in placed]
        placed = [replace(p, pose=p.pose.scaled(1 / factor), distance=p.distance / factor) for p in placed]
        placed = sorted(placed, key=lambda p: p.distance)[:keep]
    alike = _different(placed)
    chosen = alike[0] if len(alike) == 1 else min(alike, key=lambda p: _unlike(mesh, ink, p.pose))
    final = _refined(scene, outline, chosen.pose, _ROUNDS[-1], focal_pixels)
    camera = final.pose.camera(width, height)
    seen = seen_outline(scene, camera)
    overlap = float((seen.region & outline.region).sum() / max(1, (seen.region | outline.region).sum()))
    return CameraFit(camera, final.distance, overlap, len(poses), len(alike) - 1, seen)


def _fits(found: CameraFit, outline: DrawnOutline) -> bool:
    size = math.sqrt(float(outline.region.sum()))
    return found.overlap >= LEAST_OVERLAP and found.outline_distance <= FARTHEST_OUTLINE * size


@dataclass(frozen=True, eq=False)
class _Placed:
    """A pose, and the mean distance of its outline from the drawn one in pixels of the drawing."""

    pose: Pose
    distance: float


def _refined(scene: RayScene, outline: DrawnOutline, pose: Pose, rounds: int, focal: float | None) -> _Placed:
    """The pose nearby whose outline is closest to the drawn one."""
    height, width = outline.region.shape
    target = _Target.of(outline)
    for _ in range(rounds):
        rim = seen_outline(scene, pose.camera(width, height))
        if len(rim.points) < 8:
            return _Placed(pose, diagonal(outline.region))
        pose, change = target.step(pose, rim, focal)
        if change < _SETTLED:
            break
    rim = seen_outline(scene, pose.camera(width, height))
    return _Placed(pose, target.mean_distance(pose, rim) if len(rim.points) else diagonal(outline.region))


@dataclass(frozen=True, eq=False)
class _Target:
    """A drawn outline as residuals need it; pixels from the picture's middle."""

    outline: DrawnOutline
    points: Floats
    normals: Floats
    middle: Floats
    gradient: tuple[Image, Image]
    outlier: float

    @staticmethod
    def of(outline: DrawnOutline) -> "_Target":
        height, width = outline.region.shape
        chosen = _spread(len(outline.points))
        middle = np.array([width / 2, height / 2])
        outlier = max(0.7, _OUTLIER * diagonal(outline.region))
        down, right = (np.asarray(slope) for slope in np.gradient(outline.distance))
        places, normals = outline.points[chosen] - middle, outline.normals[chosen]
        return _Target(outline, places, normals, middle, (right, down), outlier)

    def step(self, pose: Pose, rim: SeenOutline, focal: float | None) -> tuple[Pose, float]:
        """A pose nearer to the outline, and by how much it differs.

        Gauss-Newton steps on squares of distances, of which those far off count for less (iteratively reweighted), with
        the fixed points of the rim one way and, the other way, those nearest to the drawn outline's.
        """
        points = rim.points[_spread(len(rim.points))]
        away, nearest = cKDTree(pose.project(points)).query(self.points)
        back = away < max(_REACH * self.outlier, 2 * float(np.median(away)))
        opposite, goal, normals = points[nearest[back]], self.points[back], self.normals[back]
        known = _AXES if focal is None else _AXES_OF_KNOWN_FOCAL
        begin = pose
        for _ in range(_STEPS):
            if focal is not None:
                pose = replace(pose, distance=float(np.clip(focal / pose.size, NEAREST, FARTHEST)))
            there, slope = self.signed(pose.project(points))
            again = np.sum((pose.project(opposite) - goal) * normals, axis=1)
            residuals = np.concatenate([there, again])
            jacobian = np.concatenate(
                [
                    np.einsum("ni,nij->nj", slope, pose.slopes(points)),
                    np.einsum("ni,nij->nj", normals, pose.slopes(opposite)),
                ]
            )
            share = np.concatenate([np.full(len(there), 1 / len(there)), np.full(len(again), 1 / max(1, len(again)))])
            weight = share / np.sqrt(1 + (residuals / self.outlier) ** 2)
            pose = pose.moved(_solved(jacobian @ known, residuals, weight, pose.size) @ known.T)
        change = np.array([pose.angle_to(begin), (pose.u - begin.u) / begin.size, math.log(pose.size / begin.size)])
        return pose, float(np.abs(change).max())

    def signed(self, projected: Floats) -> tuple[Floats, Floats]:
        """(N,) signed distances of points to the outline, beyond the frame the way to it added, and (N, 2) slopes."""
        places = projected + self.middle - 0.5
        limit = np.array(self.outline.distance.shape[::-1]) - 1.0
        inside = np.clip(places, 0.0, limit)
        beyond = places - inside
        far = np.linalg.norm(beyond, axis=1)
        slopes = [map_coordinates(field, inside.T[::-1], order=1) for field in self.gradient]
        distance = map_coordinates(self.outline.distance, inside.T[::-1], order=1) + far
        slope = np.where(far[:, None] > 0.0, beyond / np.maximum(far, 1e-9)[:, None], np.stack(slopes, axis=1))
        return np.asarray(distance), slope

    def mean_distance(self, pose: Pose, rim: SeenOutline) -> float:
        """Mean distance between the two outlines, both ways."""
        projected = pose.project(rim.points)
        away = cKDTree(projected).query(self.points)[0]
        return float(np.abs(self.signed(projected)[0]).mean() + away.mean()) / 2


def _solved(jacobian: Floats, residuals: Floats, weight: Floats, size: float) -> Floats:
    """One Gauss-Newton step of weighted residuals, held back where they tell little and never far."""
    normal = jacobian.T @ (weight[:, None] * jacobian)
    damped = normal + np.diag(_DAMPING * np.diag(normal) + (_LOOSE * size) ** 2)
    step = -np.linalg.solve(damped, jacobian.T @ (weight * residuals))
    return np.asarray(step * min(1.0, _FARTHEST_STEP / max(float(np.abs(step).max()), 1e-12)))


def _spread(count: int) -> Floats:
    """Indices of at most `_POINTS` of so many, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, _POINTS)).astype(np.intp))


def _different(placed: Sequence[_Placed]) -> list[_Placed]:
    """The poses that fit about as well as the best, and differ from each other."""
    limit = max(_ALIKE * placed[0].distance, placed[0].distance + _ALIKE_PIXELS)
    found: list[_Placed] = []
    for one in placed:
        if one.distance <= limit and all(one.pose.angle_to(other.pose) > _DIFFERENT for other in found):
            found.append(one)
    return found


def _unlike(mesh: Mesh, ink: Image, pose: Pose) -> float:
    """How little the lines that we draw from a pose have in common with a drawing's, in a smaller picture; 0..1."""
    height, width = ink.shape
    ours = draw(mesh, camera=pose.camera(width, height)).ink()
    drawn, seen = Lines.of(thin_lines(ink)), Lines.of(thin_lines(ours))
    near = 0.008 * diagonal(drawn.mask)

    def share(lines: Lines, other: Lines) -> float:
        return float(np.exp(-other.distance[lines.mask] / near).mean()) if not lines.empty else 0.0

    return 1.0 - f1_score(share(drawn, seen), share(seen, drawn))
