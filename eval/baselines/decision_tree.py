"""The decision tree of Cole et al. (2008): how much ink a pixel has, by the maps of curvature and gradient around it.

A model tree (Quinlan's M5) splits pixels by what the maps say and has a linear model in every leaf, pruned, and
smoothed with those on the way to the root. Here it is Cubist, its author's successor to M5, which writes each leaf as a
rule: conditions, and the linear model that holds where they do. A pixel's ink is the mean over the rules that hold.

References:
    Cole, Golovinskiy, Limpaecher, Barros, Finkelstein, Funkhouser, Rusinkiewicz: Where Do People Draw Lines? SIGGRAPH
    2008.
    Quinlan: Learning with Continuous Classes. AI 1992.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from eval.baselines.tree_features import NAMES, feature_maps, near_surface
from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.plan import Plan
from ncmodel.errors import InputError
from ncmodel.files import write_text
from ncmodel.model.ridge_detection import RidgeOptions, chained, find_ridges
from ncmodel.parsing import parse_json
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image, Mask, Thresholds

KIND = "neural-contours decision tree"
VERSION = 1


@dataclass(frozen=True)
class Rule:
    """A leaf: where it holds, and the linear model there. Features are meant by their names, as `NAMES` has them.

    Attributes:
        above: Feature -> number that it lies above.
        up_to: Feature -> number that it is at most.
        constant: Of the linear model.
        slopes: Feature -> factor; the others have none.
        low: The model's value is at least this.
        high: And at most this: both are the extremes of the leaf's examples.
    """

    above: Mapping[str, float]
    up_to: Mapping[str, float]
    constant: float
    slopes: Mapping[str, float]
    low: float
    high: float

    def __post_init__(self) -> None:
        unknown = {*self.above, *self.up_to, *self.slopes} - set(NAMES)
        numbers = [*self.above.values(), *self.up_to.values(), *self.slopes.values(), self.constant]
        if unknown or not np.isfinite(numbers).all() or not 0.0 <= self.low <= self.high <= 1.0:
            raise ValueError(f"{self}: expected finite numbers, known features and 0 <= low <= high <= 1")

    def holds(self, features: Image) -> Mask:
        """(P,) for which of (F, P) features."""
        found = np.ones(features.shape[1], dtype=np.bool_)
        for name, bound in self.above.items():
            found &= features[NAMES.index(name)] > bound
        for name, bound in self.up_to.items():
            found &= features[NAMES.index(name)] <= bound
        return found

    def value(self, features: Image) -> Floats:
        """(P,) what the linear model says of (F, P) features."""
        total = np.full(features.shape[1], self.constant)
        for name, slope in self.slopes.items():
            total += slope * features[NAMES.index(name)]
        return np.asarray(np.clip(total, self.low, self.high), dtype=np.float64)


@dataclass(frozen=True)
class Tree:
    """A trained decision tree.

    Attributes:
        rules: Its leaves; at least one.
        mean: What is predicted where none holds: the mean of the examples.
        ridges: What counts as a line in the map that it predicts.
        training: What it was trained on, for the record.
    """

    rules: tuple[Rule, ...]
    mean: float
    ridges: RidgeOptions = field(default_factory=RidgeOptions)
    training: Mapping[str, Any] = field(default_factory=dict)

    def predict(self, features: Image) -> Floats:
        """(P,) ink that is expected of pixels, by their (F, P) features."""
        total, count = np.zeros(features.shape[1]), np.zeros(features.shape[1])
        for rule in self.rules:
            here = np.flatnonzero(rule.holds(features))
            total[here] += rule.value(features[:, here])
            count[here] += 1
        return np.where(count > 0, total / np.maximum(count, 1), self.mean)

    def save(self, path: str | Path) -> None:
        """Write it as JSON."""
        record = {"kind": KIND, "version": VERSION, "features": list(NAMES), **asdict(self)}
        write_text(Path(path), json.dumps(record, indent=1, allow_nan=False) + "\n")

    @staticmethod
    def load(path: str | Path) -> "Tree":
        """Read what `save` wrote.

        Raises:
            InputError: It is something else, of another version, or damaged.
        """
        expected = f"a {KIND} of version {VERSION}"
        try:
            record = parse_json(Path(path).read_text(encoding="utf-8"))
            found = (record["kind"], record["version"], record["features"])
            if found != (KIND, VERSION, list(NAMES)):
                raise InputError(path, f"a {found[0]} of version {found[1]}, {len(found[2])} features", expected)
            rules = tuple(Rule(**rule) for rule in record["rules"])
            return Tree(rules, float(record["mean"]), RidgeOptions(**record["ridges"]), record["training"])
        except OSError as error:
            raise InputError(path, f"can't be read ({error.strerror})", expected) from error
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(path, f"no such file's content ({error})", expected) from error


def expected_ink(view: View, tree: Tree) -> Image:
    """(H, W) ink that the tree expects of each pixel; none on empty paper."""
    near, maps = near_surface(view), feature_maps(view)
    ink = np.zeros(near.shape, dtype=np.float32)
    ink[near] = tree.predict(maps[:, near])
    return ink


def draw(view: View, tree: Tree, ink: Image | None = None) -> Drawing:
    """The lines along the ridges of the ink that is expected, as the image branch's lines are found and drawn.

    Args:
        view: The view.
        tree: The tree.
        ink: (H, W) what `expected_ink` says of it, if that is known.
    """
    ridges = find_ridges(expected_ink(view, tree) if ink is None else ink, tree.ridges)
    return draw_view(view, Plan((), Thresholds(None, None, None, None), chained(ridges)))
