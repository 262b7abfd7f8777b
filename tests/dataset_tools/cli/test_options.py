"""The commands' defaults are those of the settings that they fill in."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

import pytest

from dataset_tools.cli import questionnaires, simulation, site, study, votes
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Scheme
from dataset_tools.simulation.participants import Crowd
from dataset_tools.simulation.study_participants import StudyCrowd
from dataset_tools.site.database import Policy
from dataset_tools.site.participant_pages import CONSENT, Settings
from dataset_tools.site.server import site_parameters
from dataset_tools.study.design import StudyScheme
from dataset_tools.votes.consensus import Rules

STUDY_SIDE = {"drawing_side": lambda side: {768: 512}[side]}
"""A study shows two drawings where a question of the crowd shows eight: they are larger."""


@pytest.mark.parametrize(
    ("command", "settings", "units", "missing"),
    [
        (questionnaires.build, Scheme, {}, set()),
        (questionnaires.topup, Scheme, {}, {"votes"}),  # there an argument has this name
        (questionnaires.build, Look, {}, set()),
        (questionnaires.topup, Look, {}, set()),
        (study.build, StudyScheme, {}, set()),
        (study.build, Look, STUDY_SIDE, set()),
        (study.topup, Look, STUDY_SIDE, set()),
        (study.simulate, StudyCrowd, {}, {"seconds"}),
        (simulation.simulate, Crowd, {}, {"far", "slip", "seconds"}),
        (simulation.trial, Crowd, {}, {"far", "slip", "seconds"}),
        (votes.aggregate, Rules, {"validation_shapes": lambda text: tuple(text.split())}, set()),
        (
            site.serve,
            Policy,
            {"abandoned_after": lambda minutes: 60 * minutes, "taken_part": lambda files: frozenset(files or ())},
            set(),
        ),
        (
            site.serve,
            Settings,
            {"parameters": site_parameters, "consent": lambda file: file or CONSENT},
            {"link_token"},
        ),
    ],
)
def test_a_commands_defaults_are_those_of_its_settings(
    command: Callable[..., None],
    settings: type[Any],
    units: Mapping[str, Callable[[Any], Any]],
    missing: set[str],
) -> None:
    """`units`: option -> what the command makes of its value; `missing`: settings that the command doesn't offer."""
    options = {
        name: parameter.default
        for name, parameter in inspect.signature(command).parameters.items()
        if parameter.default is not inspect.Parameter.empty
    }
    defaults = {one.name: getattr(settings(), one.name) for one in fields(settings)}
    assert defaults.keys() - options.keys() == missing
    found = {name: units.get(name, lambda value: value)(options[name]) for name in defaults.keys() - missing}
    assert found == {name: defaults[name] for name in found}
