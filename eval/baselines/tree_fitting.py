"""How the decision tree learns: examples of pixels, Cubist, and what counts as a line in what it predicts."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from eval.baselines.decision_tree import Rule, Tree, draw, expected_ink
from eval.baselines.tree_features import NAMES, feature_maps, near_surface
from eval.measures.evaluation import Target
from ncmodel.chamfer import chamfer_distance
from ncmodel.errors import UsageError
from ncmodel.model.ridge_detection import RidgeOptions
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image

INKED = 0.5
"""Ink from which on a pixel counts as line when examples are drawn."""

RULES = 100
"""Leaves that a tree has at most."""

RIDGES = tuple(
    RidgeOptions(low=share * high, high=high, full=share * high)
    for high, share in product((0.3, 0.4, 0.5, 0.6, 0.7, 0.8), (0.5, 0.75))
)
"""What is tried as a line. All are drawn in full ink: of lines, nothing but where they are is known."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Pixels to learn from.

    Attributes:
        features: (F, P) what the maps say of each.
        ink: (P,) that each has.
    """

    features: Image
    ink: Floats

    @staticmethod
    def together(parts: Sequence["Examples"]) -> "Examples":
        """All of several views."""
        return Examples(
            np.concatenate([part.features for part in parts], axis=1), np.concatenate([part.ink for part in parts])
        )


def examples_of(view: View, ink: Image, count: int, rng: np.random.Generator) -> Examples:
    """Pixels of one view: half of them with ink, half of them background, as far as there are so many.

    Of background there is twenty times as much, and most of it says the same. So the ink that is predicted is that of
    pixels among which every other has some: higher than the share of all pixels. Empty paper is left out.

    Args:
        view: The view.
        ink: (H, W) of the drawing to learn.
        count: Of pixels.
        rng: Draws them.
    """
    near = near_surface(view)
    kinds = [np.flatnonzero(near & (inked == (ink >= INKED))) for inked in (True, False)]
    chosen = [rng.choice(kind, min(count // 2, len(kind)), replace=False) for kind in kinds]
    pixels = np.sort(np.concatenate(chosen))
    maps = feature_maps(view)
    return Examples(maps.reshape(len(maps), -1)[:, pixels], ink.ravel()[pixels].astype(np.float64))


def fit(examples: Examples, rules: int = RULES) -> Tree:
    """A tree with the least error on examples.

    Raises:
        UsageError: Cubist isn't installed.
    """
    try:
        import pandas as pd
        from cubist import Cubist
    except ImportError as error:
        raise UsageError(f"cubist is missing, pip install 'neural-contours[tree]' ({error})") from error
    # Unbiased leaves predict means, not medians: with as much background as ink, medians would be 0 or 1.
    cubist = Cubist(n_rules=rules, unbiased=True, extrapolation=0.0, random_state=0)
    cubist.fit(pd.DataFrame(examples.features.T, columns=list(NAMES)), examples.ink)
    return Tree(_rules(cubist.model_), float(cubist.global_mean_))


def _rules(model: str) -> tuple[Rule, ...]:
    """The rules in Cubist's own description: a line for a rule's size and range, one a condition, one for its model."""
    found: list[Rule] = []
    above: dict[str, float] = {}
    up_to: dict[str, float] = {}
    low = high = 0.0
    for line in model.splitlines():
        pairs = re.findall(r'(\w+)="([^"]*)"', line)
        values = dict(pairs)
        if "conds" in values:
            above, up_to = {}, {}
            low, high = float(values["loval"]), float(values["hival"])
        elif "cut" in values:
            # A rule may name a feature several times; the narrowest bound counts.
            name, cut = values["att"], float(values["cut"])
            if values["result"] == ">":
                above[name] = max(cut, above.get(name, cut))
            else:
                up_to[name] = min(cut, up_to.get(name, cut))
        elif "coeff" in values:
            factors = [float(value) for key, value in pairs if key == "coeff"]
            slopes = dict(zip((value for key, value in pairs if key == "att"), factors[1:], strict=True))
            found.append(Rule(above, up_to, factors[0], slopes, low, high))
    return tuple(found)


def ridge_costs(view: View, target: Target, tree: Tree, tried: Sequence[RidgeOptions] = RIDGES) -> Floats:
    """(N,) Chamfer distances of drawings with N kinds of lines on one view, the mean over its references."""
    ink = expected_ink(view, tree)
    drawings = (target.prepare(draw(view, replace(tree, ridges=ridges), ink).ink()) for ridges in tried)
    means = [np.mean([chamfer_distance(lines, other) for other in target.references.values()]) for lines in drawings]
    return np.array(means, dtype=np.float64)
