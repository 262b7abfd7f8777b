"""Repair of meshes as they come: one entry, `clean`, and a report of what was found, done and left.

In this order, each step only where it finds something to do, so that a sound mesh keeps its vertex and face order:

1. faces with coordinates that aren't numbers, or are absurdly far from all others, are dropped; +y up; longest side 1,
   centred;
2. vertices closer than `weld` become one, faces without area and repeated faces are dropped (whatever their winding:
   of a double-sided face one side is left);
3. borders that touch within `snap` are connected, vertex to vertex and vertex to edge;
4. rays from outside tell for every face which side is seen. At edges with more than two faces, the faces around the
   most exposed wedges are joined. Every fan of joined faces gets its own vertex, so that no edge or vertex is left
   non-manifold. Each patch of joined faces is wound consistently and turned so that the side seen more is its front:
   inverted shells, mixed winding and inside-out parts, open or closed;
5. patches of which nothing is seen from outside (inner walls, hidden shells) are removed: no line can be drawn on
   them, but they distort curvature where they touch and the statistics of the whole;
6. in parts made of flat pieces, hard edges get a row of vertices on either side, `support` away: without it smoothed
   normals, and the lines that depend on them, wander over the flats (see `dataset_tools.cleaning.support_loops`).

Holes are not closed (open surfaces are drawn as such) and self-intersections are left alone (the visible lines stop at
them as at any other surface).
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.cleaning.diagnostics import Faults, diagnose, sliver_faces
from dataset_tools.cleaning.exterior_visibility import exposure
from dataset_tools.cleaning.half_edges import HalfEdges, Patches, half_edges, patches_of, plain_pairs, split_vertices
from dataset_tools.cleaning.non_manifold import halve_tangled_edges, pair_faces
from dataset_tools.cleaning.stitching import merge_border_vertices, split_at_touching_vertices
from dataset_tools.cleaning.support_loops import support_hard_edges
from ncmodel.errors import MeshError
from ncmodel.mesh.load import normalise, read_geometry, upright
from ncmodel.mesh.weld import weld
from ncmodel.types import Floats, Ints, Mask, Mesh

LOOSE_FACES = 2
"""A patch of so few faces is no surface."""

MAX_LOOSE_SHARE = 0.5
"""A mesh with more of its area in such patches is refused: no line on it would mean anything."""

MAX_STRAY_SHARE = 0.01
"""Triangles that hang together with nothing are taken for debris up to this share of the area."""

FAR = 1e6
"""A vertex this many times as far from the middle as half of them is an accident: single precision can't hold both."""

PATCH_WEIGHT = 0.01
"""What the exposure of its patch counts beside a face's own."""

BALANCED = 1e-3
"""The two sides of a patch count as seen equally when they differ by less than this share of the half space."""


@dataclass(frozen=True)
class CleanSettings:
    """How a mesh is repaired. Lengths are relative to the longest side of the bounding box.

    Attributes:
        weld: Vertices closer than this become one.
        snap: Borders closer than this are connected.
        remove_hidden: Remove patches of which nothing is seen from outside.
        support: Distance of the vertices put beside hard edges; 0 puts none.
    """

    weld: float = 1e-5
    snap: float = 2e-4
    remove_hidden: bool = True
    support: float = 0.004

    def __post_init__(self) -> None:
        if not 0 <= self.weld <= self.snap < 0.1:
            raise ValueError(f"weld is {self.weld} and snap is {self.snap}, expected 0 <= weld <= snap < 0.1")
        if not 0 <= self.support < 0.1:
            raise ValueError(f"support is {self.support}, expected 0 <= support < 0.1")


@dataclass(frozen=True)
class Step:
    """One kind of repair and how many elements it touched."""

    step: str
    count: int


@dataclass(frozen=True)
class CleanReport:
    """What the cleaning of one mesh came to.

    Attributes:
        found: The faults of the mesh as it was read.
        done: The repairs, in order; those that found nothing to do are left out.
        left: What is still wrong with the result.
        resolution: Faces of the repaired surface, before any were divided along hard edges.
    """

    found: Faults
    done: tuple[Step, ...]
    left: Faults
    resolution: int

    def to_record(self) -> dict[str, Any]:
        """The report as `clean.json` holds it."""
        return asdict(self)


def clean_file(path: str | Path, up: str = "y", settings: CleanSettings | None = None) -> tuple[Mesh, CleanReport]:
    """Read a mesh file and repair it.

    Args:
        path: The mesh file.
        up: Its upward axis, "y" or "z".
        settings: Tolerances.

    Raises:
        MeshError: The file can't be read, or no surface is left of it.
    """
    vertices, faces = read_geometry(path)
    return clean(upright(vertices, up), faces, Path(path).stem, settings, source=path)


def clean(
    vertices: Floats,
    faces: Ints,
    name: str = "mesh",
    settings: CleanSettings | None = None,
    source: str | Path | None = None,
) -> tuple[Mesh, CleanReport]:
    """Repair a mesh, as the module's header says.

    Args:
        vertices: (V, 3), in any units, NaN allowed.
        faces: (F, 3).
        name: The shape's name.
        settings: Tolerances.
        source: What to call the mesh in error messages.

    Raises:
        MeshError: No surface is left.
    """
    label, settings = source or name, settings or CleanSettings()
    usable = _usable(vertices)
    sound = usable[faces].all(axis=1) if len(faces) else np.zeros(0, dtype=bool)
    if not sound.any():
        raise MeshError(label, f"{len(vertices)} vertices and no usable face of {len(faces)}", "a mesh with faces")
    work = _Repair(*_placed(*_compact(vertices, faces[sound], usable), label), settings)
    found = diagnose(work.vertices, work.faces, settings.weld, settings.snap, int((~usable).sum()))
    work.note("faces with unusable coordinates dropped", int((~sound).sum()))
    work.weld_and_drop()
    work.connect_borders()
    if len(work.faces) == 0:
        raise MeshError(label, f"all {len(faces)} faces are degenerate", "a mesh with faces of some size")
    seen = exposure(work.vertices, work.faces)
    seen, patches = work.join(seen)
    _check_surface(work.vertices, work.faces, patches, label)
    work.show_fronts(seen, patches)
    stray = _stray(work.vertices, work.faces)
    work.remove_faces(stray, "stray triangles removed")
    if settings.remove_hidden:
        work.remove_faces(_hidden(seen, patches)[~stray], "faces hidden from outside removed")
    work.drop_unused()
    resolution = len(work.faces)
    if settings.support > 0:
        work.support_hard_edges()
    mesh = Mesh(normalise(work.vertices), work.faces, name, tuple(f"{step.step}: {step.count}" for step in work.done))
    left = diagnose(mesh.vertices, mesh.faces, settings.weld, settings.snap, by_index=True)
    return mesh, CleanReport(found, tuple(work.done), left, resolution)


class _Repair:
    """A mesh under repair and the steps taken so far."""

    def __init__(self, vertices: Floats, faces: Ints, settings: CleanSettings) -> None:
        self.vertices, self.faces, self.settings = vertices, faces, settings
        self.done: list[Step] = []

    def note(self, step: str, count: int) -> None:
        """Record a step that touched something."""
        if count:
            self.done.append(Step(step, count))

    def weld_and_drop(self) -> None:
        """Merge near vertices, then drop slivers and repeated faces."""
        before = len(self.vertices)
        self.vertices, self.faces = weld(self.vertices, self.faces, self.settings.weld)
        self.note("coincident vertices welded", before - len(self.vertices))
        self._drop_faces()

    def connect_borders(self) -> None:
        """Connect borders that touch."""
        self.faces, merged = merge_border_vertices(self.vertices, self.faces, self.settings.snap)
        self.note("border vertices merged", merged)
        self._drop_faces()
        self.faces, split = split_at_touching_vertices(self.vertices, self.faces, self.settings.snap)
        self.note("border edges split at a vertex that touches them", split)
        self._drop_faces()

    def join(self, seen: Floats) -> tuple[Floats, Patches]:
        """Decide which faces are joined, and split the vertices where they aren't.

        Returns:
            The exposure of the faces, some of which may have been split, and the patches that they form.
        """
        smoothed = _with_neighbours(half_edges(self.faces), seen)
        self.vertices, self.faces, origin = halve_tangled_edges(self.vertices, self.faces, smoothed)
        self.note("faces split to tell surfaces at an edge apart", len(self.faces) - len(seen))
        sides = half_edges(self.faces)
        pairs = pair_faces(self.vertices, self.faces, sides, smoothed[origin], origin)
        patches = patches_of(len(self.faces), sides, pairs)
        self.note("edges cut to make a one-sided patch orientable", patches.cut)
        before = len(self.vertices)
        self.vertices, self.faces = split_vertices(self.vertices, self.faces, sides, patches.pairs)
        self.note("vertices split where faces don't form a surface", len(self.vertices) - before)
        return seen[origin], patches

    def show_fronts(self, seen: Floats, patches: Patches) -> None:
        """Wind each patch consistently, its front on the side that is seen more.

        `ncmodel.scene.orientation.turn_outwards` decides by volumes, without a ray, since a drawing can't wait for
        them; sheets have none. Of cessna, made of sheets, it leaves 45 % of the area with the back seen more, this 0.1.
        """
        turned = patches.flipped ^ _inward(self.vertices, self.faces, seen, patches)[patches.label]
        self.faces = np.where(turned[:, None], self.faces[:, [0, 2, 1]], self.faces)
        self.note("faces turned to face outwards", int(turned.sum()))

    def remove_faces(self, remove: Mask, step: str) -> None:
        """Remove the faces selected by a mask."""
        self.faces = self.faces[~remove]
        self.note(step, int(remove.sum()))

    def drop_unused(self) -> None:
        """Remove vertices that no face uses."""
        before = len(self.vertices)
        used = np.zeros(before, dtype=bool)
        used[self.faces] = True
        self.vertices, self.faces = _compact(self.vertices, self.faces, used)
        self.note("unused vertices removed", before - len(self.vertices))

    def support_hard_edges(self) -> None:
        """Put vertices beside hard edges."""
        before = len(self.vertices)
        self.vertices, self.faces = support_hard_edges(self.vertices, self.faces, self.settings.support)
        self.note("vertices put beside hard edges", len(self.vertices) - before)

    def _drop_faces(self) -> None:
        slivers = sliver_faces(self.vertices, self.faces)
        self.faces = self.faces[~slivers]
        self.note("degenerate faces dropped", int(slivers.sum()))
        before = len(self.faces)
        self.faces = _without_repeats(self.faces)
        self.note("repeated faces dropped", before - len(self.faces))


def _usable(vertices: Floats) -> Mask:
    """(V,) which vertices have finite coordinates, not so far away that nothing else would have any size."""
    finite: Mask = np.asarray(np.isfinite(vertices).all(axis=1))
    if not finite.any():
        return finite
    with np.errstate(over="ignore", invalid="ignore"):
        away = np.abs(vertices - np.median(vertices[finite], axis=0)).max(axis=1)
    apart = away[finite & (away > 0)]
    usable: Mask = finite & (away <= FAR * np.median(apart)) if len(apart) else finite
    return usable


def _compact(vertices: Floats, faces: Ints, keep: Mask) -> tuple[Floats, Ints]:
    """Leave out vertices that no face uses, in the old order."""
    return vertices[keep], (np.cumsum(keep) - 1)[faces]


def _placed(vertices: Floats, faces: Ints, label: str | Path) -> tuple[Floats, Ints]:
    used = vertices[np.unique(faces)]
    if bool((used == used[0]).all()):
        raise MeshError(label, f"all faces lie at one point, {used[0].tolist()}", "a shape of some size")
    return normalise(vertices, used), faces


def _without_repeats(faces: Ints) -> Ints:
    """The first of each set of faces with the same corners, in the old order."""
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return faces[np.sort(first)]


def _with_neighbours(sides: HalfEdges, seen: Floats) -> Floats:
    """Exposure of faces, raised a little by that of the patch they lie on.

    That decides where a face itself is seen from no sampled direction, as deep in a fold.
    """
    patches = patches_of(len(seen), sides, plain_pairs(sides))
    aligned = np.where(patches.flipped[:, None], seen[:, ::-1], seen)
    size = np.bincount(patches.label)
    mean = np.stack([np.bincount(patches.label, aligned[:, side]) / size for side in (0, 1)], axis=1)[patches.label]
    return np.asarray(seen + PATCH_WEIGHT * np.where(patches.flipped[:, None], mean[:, ::-1], mean))


def _inward(vertices: Floats, faces: Ints, seen: Floats, patches: Patches) -> Mask:
    """Per patch, whether its back is seen more than its front (equally seen, as a flat sheet is: left as it was)."""
    area = _areas(vertices, faces)
    front = area * (seen[:, 0] - seen[:, 1]) * np.where(patches.flipped, -1.0, 1.0)
    balance = np.bincount(patches.label, front)
    scale = np.bincount(patches.label, area)
    return np.asarray(balance < -BALANCED * scale)


def _hidden(seen: Floats, patches: Patches) -> Mask:
    """(F,) faces of patches of which nothing is seen from outside."""
    return ~np.isin(patches.label, patches.label[seen.any(axis=1)])


def _stray(vertices: Floats, faces: Ints) -> Mask:
    """(F,) triangles that share no vertex with another, where they are but a small part of the whole."""
    single = (np.bincount(faces.ravel(), minlength=len(vertices))[faces] == 1).all(axis=1)
    area = _areas(vertices, faces)
    return single if area[single].sum() <= MAX_STRAY_SHARE * area.sum() else np.zeros_like(single)


def _areas(vertices: Floats, faces: Ints) -> Floats:
    corners = vertices[faces]
    return (
        np.asarray(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)) / 2
    )


def _check_surface(vertices: Floats, faces: Ints, patches: Patches, label: str | Path) -> None:
    area = _areas(vertices, faces)
    loose = (np.bincount(patches.label) <= LOOSE_FACES)[patches.label]
    share = area[loose].sum() / area.sum()
    if share > MAX_LOOSE_SHARE and len(faces) > LOOSE_FACES:
        found = f"{share:.0%} of the area lies in {int(loose.sum())} loose triangles of {len(faces)}"
        raise MeshError(label, found, "triangles that form a surface")
