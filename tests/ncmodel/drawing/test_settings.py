"""The 256 settings: their order, what they are unions of, and that what is drawn of them is what they say."""

import numpy as np
import pytest

from dataset_tools.candidates.candidates import CandidateThresholds, specs_of
from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.settings import INK_LEVEL, Levels, Setting, draw_layers
from ncmodel.export.png import strokes_ink
from ncmodel.types import LineFamily
from tests.helpers.views import bumpy, orbited


def test_settings_are_the_first_256_candidates_of_data_sets() -> None:
    settings = Levels().settings
    assert len(set(settings)) == 256
    assert [setting.layers for setting in settings] == [spec.layers for spec in specs_of(CandidateThresholds())[:256]]
    assert settings[0] == Setting(0.001, 0.01, 0.03, creases=False, borders=False)
    assert settings[1] == Setting(0.001, 0.01, 0.03, creases=False, borders=True)
    assert settings[-1] == Setting(None, None, None, creases=True, borders=True)


def test_members_are_the_layers_by_name() -> None:
    levels = Levels()
    names = [layer.name for layer in levels.layers]
    assert len(names) == 12
    for setting, row in zip(levels.settings, levels.members, strict=True):
        assert [name for name, member in zip(names, row, strict=True) if member] == sorted(
            setting.layers, key=names.index
        )


@pytest.mark.parametrize(
    ("setting", "families"),
    [
        (Setting(None, None, None, creases=False, borders=False), ()),
        (Setting(0.01, None, None, creases=True, borders=False), (LineFamily.SUGGESTIVE, LineFamily.CREASES)),
        (
            Setting(None, 0.1, 0.3, creases=False, borders=True),
            (LineFamily.APPARENT, LineFamily.RIDGES, LineFamily.VALLEYS, LineFamily.BOUNDARIES),
        ),
    ],
)
def test_a_plan_has_the_families_and_thresholds_of_its_setting(
    setting: Setting, families: tuple[LineFamily, ...]
) -> None:
    plan = setting.plan()
    assert len(plan.families) == len(set(plan.families))
    assert set(plan.families) == {LineFamily.CONTOURS, *families}
    assert plan.thresholds.unit == "rtsc"
    assert plan.thresholds.value(LineFamily.SUGGESTIVE) == setting.suggestive
    assert plan.thresholds.value(LineFamily.APPARENT) == setting.apparent
    assert {plan.thresholds.value(f) for f in (LineFamily.RIDGES, LineFamily.VALLEYS)} == {setting.ridges_valleys}


def test_a_drawing_of_a_plan_shows_lines_of_its_families_where_its_layers_are() -> None:
    view = orbited(*bumpy(), side=96)
    drawings = draw_layers(view, Levels())
    index = Levels().settings.index(Setting(0.001, None, 0.03, creases=False, borders=False))
    plan = Levels().settings[index].plan()
    drawing = draw_view(view, plan)
    assert {stroke.family for stroke in drawing.strokes} <= set(plan.families)
    assert len({stroke.family for stroke in drawing.strokes}) > 1
    inked, union = strokes_ink(drawing.strokes, view.camera) > INK_LEVEL, drawings.drawing(index) > 0
    assert inked.any()
    assert (inked & ~union).sum() < 0.2 * inked.sum()


def test_a_drawing_is_the_maximum_of_its_layers_and_its_mask_their_union() -> None:
    drawings = draw_layers(orbited(*bumpy(), side=64), Levels())
    assert drawings.masks[0].any()
    for index in (0, 100, 255):
        member = drawings.levels.members[index]
        assert np.array_equal(drawings.drawing(index), np.maximum.reduce(drawings.ink[member]))
        assert np.array_equal(drawings.drawing(index) > INK_LEVEL, drawings.masks[member].any(axis=0))
