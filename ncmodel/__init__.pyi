# The names of `__init__.py`, for type checkers. Without a docstring, that of `__init__.py` is shown on the API pages.

from ncmodel.camera import Camera as Camera
from ncmodel.drawing.draw import draw as draw_shape
from ncmodel.drawing.drawing import Drawing as Drawing
from ncmodel.errors import NeuralContoursError as NeuralContoursError
from ncmodel.mesh.load import load_mesh as load_mesh
from ncmodel.mesh.load import make_mesh as make_mesh
from ncmodel.mesh.objects import as_mesh as as_mesh
from ncmodel.model.scoring import score_drawing as score_drawing
from ncmodel.published.model import load_model as load_model
from ncmodel.scene.feature_arrays import features as features
from ncmodel.scene.surface import Surface as Surface
from ncmodel.scene.view import View as View
from ncmodel.sheets.sheet import Layout as Layout
from ncmodel.sheets.sheet import draw_sheet as draw_sheet
from ncmodel.types import LineFamily as LineFamily
from ncmodel.types import Mesh as Mesh
from ncmodel.types import Stroke as Stroke
from ncmodel.types import Thresholds as Thresholds

__all__ = [
    "Camera",
    "Drawing",
    "Layout",
    "LineFamily",
    "Mesh",
    "NeuralContoursError",
    "Stroke",
    "Surface",
    "Thresholds",
    "View",
    "as_mesh",
    "draw_shape",
    "draw_sheet",
    "features",
    "load_mesh",
    "load_model",
    "make_mesh",
    "score_drawing",
]
