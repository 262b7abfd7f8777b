"""Neural Contours: learned line drawings of 3D shapes.

    from ncmodel import draw_shape

    drawing = draw_shape("bunny.obj", lines=["contours", "suggestive"])
    drawing.save("bunny.svg")
    drawing  # shows itself in a notebook

The names below are imported when first used, so that `import ncmodel` costs nothing. `__init__.pyi` tells them to type
checkers.
"""

import importlib
from typing import Any

_EXPORTS = {
    "Camera": "ncmodel.camera:Camera",
    "Drawing": "ncmodel.drawing.drawing:Drawing",
    "Layout": "ncmodel.sheets.sheet:Layout",
    "LineFamily": "ncmodel.types:LineFamily",
    "Mesh": "ncmodel.types:Mesh",
    "NeuralContoursError": "ncmodel.errors:NeuralContoursError",
    "Stroke": "ncmodel.types:Stroke",
    "Surface": "ncmodel.scene.surface:Surface",
    "Thresholds": "ncmodel.types:Thresholds",
    "View": "ncmodel.scene.view:View",
    "as_mesh": "ncmodel.mesh.objects:as_mesh",
    # Not `draw`: that is the module's name, and would mean one or the other by what was imported before.
    "draw_shape": "ncmodel.drawing.draw:draw",
    "draw_sheet": "ncmodel.sheets.sheet:draw_sheet",
    "features": "ncmodel.scene.feature_arrays:features",
    "load_mesh": "ncmodel.mesh.load:load_mesh",
    "load_model": "ncmodel.published.model:load_model",
    "make_mesh": "ncmodel.mesh.load:make_mesh",
    "score_drawing": "ncmodel.model.scoring:score_drawing",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, attribute = _EXPORTS[name].partition(":")
    return getattr(importlib.import_module(module), attribute)


def __dir__() -> list[str]:
    return __all__
