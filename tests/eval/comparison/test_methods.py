"""Rows are named as in the paper, by how a model was trained and by what it reads."""

from dataclasses import replace

import pytest

from eval.comparison.methods import image_row, learned_methods, row_names
from eval.comparison.tables import learned_rows
from ncmodel.model.predictor import Model
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.presets import CURVATURE_MAPS, MAPS
from ncmodel.nets.translation import TranslationBranch
from tests.helpers.micro_training import MICRO


def image_branch(inputs: tuple[str, ...], objective: str | None = None) -> Checkpoint:
    """A checkpoint with nothing but an image branch."""
    preset = replace(MICRO, translation=replace(MICRO.translation, inputs=inputs))
    record = {} if objective is None else {"objective": objective}
    translator = TranslationBranch(preset.translation, preset.inputs)
    return Checkpoint(preset, translator=translator, training={"stages": {"translator": record}})


@pytest.mark.parametrize(
    ("inputs", "objective", "row"),
    [
        (MAPS, None, "NC-image"),
        (MAPS, "my_losses:Own", "NC-image"),
        (MAPS, "ncmodel.training.adversarial:Pix2pixHDObjective", "pix2pixHD"),
        (("depth", "shaded_0"), None, "NC-image-noms"),
        ((*MAPS, *CURVATURE_MAPS), None, "NC-image-curv"),
        (("depth",), None, "NC-image"),
    ],
)
def test_an_image_branch_has_the_paper_s_row(inputs: tuple[str, ...], objective: str | None, row: str) -> None:
    checkpoint = image_branch(inputs, objective)
    assert image_row(checkpoint) == row
    (method,) = learned_methods({"x": Model(checkpoint)}, "draft")
    assert method.name == f"{row}@x"
    assert learned_rows([method.name, "draw", "all-grid"]) == [method.name]


def test_a_decision_tree_s_row_follows_the_others_that_need_no_model() -> None:
    model = Model(image_branch(MAPS))
    assert row_names({"": model}, with_tree=True)[-3:] == ["draw", "Decision Tree", "NC-image"]
    assert "Decision Tree" not in row_names({"": model})
