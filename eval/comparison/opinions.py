"""What a model says of a view's drawings, as numbers: the eight that were voted on, and the 256 it chooses among.

A model that counts ink judges by that, by its habit and by the picture; it can't judge edges, which no setting draws.
A ranking module alone judges by the picture.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dataset_tools.build.config import BuildConfig
from ncmodel.config import read_config
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.drawing.settings import LayeredDrawings, Levels
from ncmodel.model.predictor import Model
from ncmodel.model.score import PictureScore
from ncmodel.model.setting_choice import setting_scores
from ncmodel.types import Floats, Image

WHOLE, PICTURE = "", "picture"
"""By all that a model goes by when it chooses; by pictures alone."""


@dataclass(frozen=True, eq=False)
class Opinion:
    """Scores, higher is better.

    Attributes:
        selected: Of the eight drawings that were voted on; None for those that can't be judged.
        candidates: (256,) of each setting's drawing.
    """

    selected: Sequence[float | None]
    candidates: Floats


def opinions(
    model: Model, maps: Image, selected: Sequence[Image], settings: Sequence[int | None], drawings: LayeredDrawings
) -> Mapping[str, Opinion]:
    """What a model says by `WHOLE` and, where it goes by more than pictures, by `PICTURE`; empty without a ranker.

    Args:
        model: The model.
        maps: (7, H, W) depth and shaded maps of the view.
        selected: (H, W) ink of the eight drawings that were voted on.
        settings: Which setting each of them has; None for edges.
        drawings: The drawings of all settings.
    """
    ranker, counting = model.checkpoint.ranker, model.checkpoint.statistics
    found: dict[str, Opinion] = {}
    if ranker is not None:
        score = PictureScore(ranker, maps)
        candidates = score.scores(drawings.drawing(number) for number in range(len(drawings.levels.settings)))
        found[WHOLE] = Opinion(score.scores(selected).tolist(), candidates)
    if counting is not None:
        whole = setting_scores(drawings, maps, counting)
        if ranker is not None:
            found[PICTURE] = found[WHOLE]
            whole = whole + counting.mix[2].item() * found[PICTURE].candidates
        eight = [None if number is None else float(whole[number]) for number in settings]
        found = {WHOLE: Opinion(eight, whole), **{name: said for name, said in found.items() if name != WHOLE}}
    return found


def settings_of(data: DataFolder, item: Item) -> list[int | None]:
    """Which of the model's settings each of an item's eight drawings has; None for edges and for thresholds it lacks.

    Raises:
        InputError: The data folder's settings can't be read.
    """
    medoids = data.medoids(item)
    there, known = read_config(BuildConfig, data.config_path).levels.settings, Levels().settings
    places = {setting: number for number, setting in enumerate(known)}
    return [places.get(there[medoid]) if medoid < len(there) else None for medoid in medoids]
