"""Objectives by name: pix2pixHD's, and those of one's own: an installed package's entry point, or MODULE:CLASS.

An entry point in the group `neural_contours.objectives` names a class like `RankerObjective`, `TranslatorObjective` or
`FinetuneObjective`, usually derived from one of them; its `name` says which stage it is for.
"""

import importlib
from importlib.metadata import entry_points
from typing import Any

from ncmodel.errors import ArgumentError
from ncmodel.training.adversarial import Pix2pixHDObjective
from ncmodel.training.objectives import FinetuneObjective, RankerObjective, TranslatorObjective

GROUP = "neural_contours.objectives"

OBJECTIVES: dict[str, Any] = {
    objective.name: objective for objective in (RankerObjective, TranslatorObjective, FinetuneObjective)
}
"""Stage -> what it minimises unless told otherwise."""

NAMED: dict[str, Any] = {"pix2pixhd": Pix2pixHDObjective}
"""Name -> another objective that this package has."""


def objective_named(name: str) -> Any:
    """The class that is meant.

    Args:
        name: One of `NAMED`, of an entry point, or MODULE:CLASS.

    Raises:
        ArgumentError: There is none, it can't be loaded, or it is for none of the stages.
    """
    if name in NAMED:
        return NAMED[name]
    expected = f"{', '.join(NAMED)}, MODULE:CLASS, or the name of an entry point in {GROUP}"
    module, _, attribute = name.partition(":")
    point = next(iter(entry_points(group=GROUP, name=name)), None)
    if point is None and not (module and attribute):
        known = ", ".join(sorted(point.name for point in entry_points(group=GROUP))) or "none"
        raise ArgumentError("objective", repr(name), f"{expected} (installed: {known})")
    try:
        found = point.load() if point else getattr(importlib.import_module(module), attribute)
    except Exception as error:  # a stranger's module may raise anything
        raise ArgumentError("objective", f"{name!r} ({type(error).__name__}: {error})", expected) from error
    stage = getattr(found, "name", None)
    if stage not in OBJECTIVES:
        raise ArgumentError(
            "objective", f"{name!r} of stage {stage!r}", f"a class whose name is {', '.join(OBJECTIVES)}"
        )
    return found


def objective_name(objective: Any) -> str:
    """MODULE:CLASS of an objective's class: what states and checkpoints say of it."""
    return f"{objective.__module__}:{objective.__qualname__}"
