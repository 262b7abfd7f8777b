"""Training, from a data folder and ranking pairs to a checkpoint.

Beside CHECKPOINT lie CHECKPOINT.history.json (losses and measures of every pass), if wanted CHECKPOINT.curves.html (the
same as curves, while training runs too) and, for each stage that was trained, CHECKPOINT.STAGE.state (what it needs to
go on).
"""

import copy
import hashlib
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from torch import nn

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import Pair
from ncmodel.errors import ArgumentError, InputError, UsageError
from ncmodel.files import write_text
from ncmodel.nets.blocks import WIDE, initialise, threads_for
from ncmodel.nets.checkpoints import NETWORKS, Checkpoint, load_checkpoint, save_checkpoint
from ncmodel.nets.presets import Preset
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.regressor import GeometryRegressor
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.nets.translation import TranslationBranch
from ncmodel.parsing import parse_json
from ncmodel.progress import Progress, silent
from ncmodel.report.training_curves import Curves
from ncmodel.training.dataset import ViewImages, read_training_pairs, validation_notes
from ncmodel.training.loop import STAGES, Means, Plan, fit
from ncmodel.training.objectives import Objective
from ncmodel.training.options import TrainOptions as TrainOptions  # callers find it beside `run_training`
from ncmodel.training.own import OBJECTIVES, objective_name, objective_named
from ncmodel.training.processes import Team, team_of
from ncmodel.training.regression import LineImages, RegressorObjective
from ncmodel.training.state import Measures, Progressed
from ncmodel.training.statistics import DrawingNumbers, StatisticsObjective, learn_habit, learn_mix

N = TypeVar("N", bound=nn.Module)

TIME_SHARES = {"ranker": 0.5, "translator": 0.33, "finetune": 0.12, "statistics": 0.05, "regressor": 1.0}
"""How a budget of seconds is split among the stages that run."""

BASELINES = ("regressor",)
"""Stages that no preset has, since they are no part of the model: they run when asked for, alone."""


@dataclass(frozen=True)
class StageReport:
    """What a stage did.

    Attributes:
        stage: Its name.
        epochs: Passes over the data, those of earlier runs included.
        best_epoch: The pass whose weights were kept.
        validation: Measures of those weights on held-out items; empty without held-out items.
        seconds: Spent by this run.
    """

    stage: str
    epochs: int
    best_epoch: int
    validation: Measures
    seconds: float


@dataclass(frozen=True)
class TrainReport:
    """What a training run did.

    Attributes:
        checkpoint: The file.
        preset: Name of the preset.
        pairs: Number of pairs by split.
        stages: What each stage did, in order.
        history: Stage -> one record a pass: "epoch", "loss", and the validation measures.
        notes: What the reader must know: held-out views too few to choose by.
    """

    checkpoint: str
    preset: str
    pairs: dict[str, int]
    stages: list[StageReport]
    history: dict[str, list[dict[str, Any]]]
    notes: list[str] = field(default_factory=list)

    def to_record(self) -> dict[str, Any]:
        """JSON-ready values."""
        return asdict(self)


def run_training(
    data: str | Path,
    pairs: str | Path,
    out: str | Path,
    preset: Preset,
    options: TrainOptions,
    progress: Progress = silent,
    tell: Callable[[str], None] = lambda _: None,
) -> TrainReport:
    """Train some stages; write checkpoint, history and states. What an earlier run has done already is not done again.

    Under torchrun all processes train together; the first one writes, and only its report is whole.

    Args:
        data: DATA_DIR.
        pairs: pairs.jsonl.
        out: Checkpoint to write. Networks in it that the stages don't train are kept.
        preset: Which networks, and their rates.
        options: How to train.
        progress: Is told about every pass.
        tell: Is told what the report has as notes, before the first pass.

    Raises:
        InputError: The data or an earlier checkpoint can't be used.
        UsageError: An earlier training in the same place was another one, or finetuning lacks a network.
    """
    read, folder = read_training_pairs(pairs), DataFolder(data)
    folder.require(sorted({pair.item for pair in read}), pairs)
    if not Path(out).absolute().parent.is_dir():
        raise InputError(out, "its folder doesn't exist", "a file in an existing folder")
    sizes = preset.translation.size, preset.ranking.size
    images = ViewImages(folder, sizes, inputs=preset.inputs, percentile=preset.percentile)
    known = (*preset.stages, *BASELINES)
    if options.stages is not None and not set(options.stages) <= set(known):
        raise ArgumentError("stages", repr(",".join(options.stages)), f"what {preset.name!r} has: {', '.join(known)}")
    with team_of(torch.device(options.own_device)) as team:
        run = _Run(Path(out), preset, options, images, read, team)
        for name in run.stages:
            run.stage(name, progress if team.leads else silent, tell)
        if run.curves:
            run.curves.finish(run.history)
    return TrainReport(str(out), preset.name, run.counts, run.reports, run.history, run.notes)


class _Run:
    """One call of `run_training`: the networks so far, and what its stages have reported."""

    def __init__(
        self,
        out: Path,
        preset: Preset,
        options: TrainOptions,
        images: ViewImages,
        pairs: Sequence[Pair],
        team: Team,
    ) -> None:
        self.out, self.preset, self.options, self.images, self.pairs = out, preset, options, images, pairs
        self.team, self.notes = team, validation_notes(pairs)
        self.own = None if options.objective is None else objective_named(options.objective)
        self.stages = options.stages or preset.stages
        splits = [pair.split for pair in pairs]
        self.counts = {split: splits.count(split) for split in ("train", "validation")}
        self.reports: list[StageReport] = []
        self.history: dict[str, list[dict[str, Any]]] = {}
        self.history_file = out.with_name(f"{out.name}.history.json")
        page = out.with_name(f"{out.name}.curves.html")
        self.curves = Curves(page, self.notes) if options.curves and team.leads else None
        self._told = not team.leads
        self.checkpoint = Checkpoint(preset)
        if out.exists() and not (options.restart and self.stages == preset.stages):
            self._take_over()
        if options.restart:
            for name in self.stages:
                self._forget(name)
        self.team.wait()

    @cached_property
    def _pictures(self) -> str:
        """What the pairs show: drawings and maps that were made again aren't those that an earlier run learnt from."""
        return self.team.firsts(self.images.checksum(self.pairs)[:8] if self.team.leads else "")

    @property
    def records(self) -> dict[str, Any]:
        """What the checkpoint says about the stages that made it."""
        stages: dict[str, Any] = self.checkpoint.training.setdefault("stages", {})
        return stages

    def state_file(self, stage: str) -> Path:
        """Where a stage keeps what it needs to go on."""
        return self.out.with_name(f"{self.out.name}.{stage}.state")

    def stage(self, name: str, progress: Progress, tell: Callable[[str], None]) -> None:
        """Run one stage to its end and write the checkpoint.

        The ranker on numbers is trained by the first process alone: it takes moments.
        """
        plan = self._plan(name)
        if self.team.leads or name != "statistics":
            self._train(name, plan, progress, tell)
        self.team.wait()  # until the files are there that the next stage looks for

    def _train(self, name: str, plan: Plan, progress: Progress, tell: Callable[[str], None]) -> None:
        begin = time.monotonic()
        objective = self._objective(name, progress)

        def watch(done: Progressed) -> None:
            for note in () if self._told else self.notes:
                tell(note)
            self._told = True
            if self.curves and done.history:
                self.curves.show({**self.history, name: done.history})

        # The image branch doubles its few channels four times: its inner layers are wide enough for all threads.
        width = WIDE if name == "translator" else self.preset.ranking.width
        with threads_for(width):
            done = fit(objective, plan, progress, watch)
            if isinstance(objective, StatisticsObjective):
                learn_habit(objective)
                learn_mix(objective, self.checkpoint.ranker, self.images)
        if self.records.get(name, {}).get("epochs") != len(done.history):
            self._keep(objective, done)
        seconds = time.monotonic() - begin
        self.reports.append(StageReport(name, len(done.history), done.best_epoch, done.validation, seconds))

    def _take_over(self) -> None:
        """Start from the networks of an earlier checkpoint."""
        self.checkpoint = load_checkpoint(self.out)
        if self.checkpoint.preset != self.preset:
            found = f"holds networks of preset {self.checkpoint.preset.name!r}"
            alike = self.checkpoint.preset.name == self.preset.name
            wanted = "the same settings of it" if alike else f"preset {self.preset.name!r}"
            raise InputError(self.out, found, f"{wanted}, or a file that isn't there yet")
        if self.history_file.exists():
            try:
                history = parse_json(self.history_file.read_text(encoding="utf-8"))
            except ValueError as error:
                raise InputError(
                    self.history_file, f"not JSON ({error})", "what training wrote, or no such file"
                ) from error
            # The file's order is by name.
            self.history = {stage: history[stage] for stage in STAGES if stage in history}

    def _forget(self, stage: str) -> None:
        if stage == "statistics":
            self.checkpoint.statistics = None
        if self.team.leads:
            self.state_file(stage).unlink(missing_ok=True)
        self.records.pop(stage, None)

    def _plan(self, stage: str) -> Plan:
        numbers = json.dumps(self.preset.to_record(), sort_keys=True)
        pairs = repr(sorted((pair.item, pair.better, pair.worse, pair.split) for pair in self.pairs))
        settings = {
            "preset": f"{self.preset.name} {_short_hash(numbers)}",
            "seed": self.options.seed,
            "pairs": f"{len(self.pairs)} {_short_hash(pairs)}",
            "pictures": self._pictures,
        }
        if self.own and self.own.name == stage:
            settings["objective"] = objective_name(self.own)
        rates = self.preset.rates(stage)
        seconds = self.options.seconds
        if seconds is not None:
            seconds *= TIME_SHARES[stage] / sum(TIME_SHARES[name] for name in self.stages)
        means = Means() if stage == "statistics" else self.options.means(self.team)
        epochs = self.options.epochs or rates.epochs
        return Plan(self.state_file(stage), settings, epochs, self.options.seed, seconds, means)

    def _objective(self, stage: str, progress: Progress) -> Objective:
        """What a stage trains: new networks, which `fit` brings to where their state says, or those to finetune."""
        shared = (self.images, self.pairs)
        if stage == "statistics":
            assert self.preset.statistics is not None, "else it isn't among the preset's stages"
            counting = self._new(StatisticsRanker(self.preset.statistics), stage, "cpu")
            return StatisticsObjective(self.preset, counting, DrawingNumbers(self.images.data), self.pairs, progress)
        if stage == "regressor":
            regressor = self._new(GeometryRegressor(self.preset), stage)
            return RegressorObjective(self.preset, regressor, LineImages(self.images), self.pairs)
        objective: Callable[..., Objective] = OBJECTIVES[stage]
        if self.own and self.own.name == stage:
            objective = self.own
        if stage == "ranker":
            ranker = RankingModule(self.preset.ranking, self.preset.inputs)
            return objective(self.preset, self._new(ranker, stage), *shared)
        if stage == "translator":
            translator = TranslationBranch(self.preset.translation, self.preset.inputs)
            return objective(self.preset, self._new(translator, stage), *shared)
        trained = copy.deepcopy(self.checkpoint)
        for network in trained.networks.values():
            network.to(self.options.own_device)
        if trained.ranker is None or trained.translator is None:
            missing = "ranker" if trained.ranker is None else "translator"
            raise UsageError(f"{self.out}: finetuning needs both networks; train the {missing} first")
        return objective(self.preset, trained.ranker, trained.translator, *shared)

    def _new(self, network: N, stage: str, device: str | None = None) -> N:
        """A network with the weights that the seed gives it."""
        if stage in self.records and not self.state_file(stage).exists():
            lost = f"{self.out}: holds a trained {stage}, but {self.state_file(stage).name}, needed to go on, is gone"
            raise UsageError(f"{lost}; expected that file, or a restart")
        seed = np.random.SeedSequence([self.options.seed, STAGES.index(stage)]).generate_state(1)[0]
        generator = torch.Generator().manual_seed(int(seed))
        if isinstance(network, StatisticsRanker):
            network.initialise(generator)
        else:
            initialise(network, generator)
        return network.to(device or self.options.own_device)

    def _keep(self, objective: Objective, done: Progressed) -> None:
        """Put a stage's networks into the checkpoint. What was trained on earlier ones is void."""
        for name, network in objective.networks.items():
            if name in NETWORKS:  # discriminators are of use to training alone
                setattr(self.checkpoint, name, network)
        for later in ("finetune", "statistics"):
            if STAGES.index(objective.name) < STAGES.index(later):
                self._forget(later)
        self.records[objective.name] = {
            "epochs": len(done.history),
            "best_epoch": done.best_epoch,
            "learning_rate": objective.rates.learning_rate,
            "batch": objective.rates.batch,
            "seed": self.options.seed,
            "pairs": self.counts,
            "validation": done.validation,
        }
        if self.own and self.own.name == objective.name:
            self.records[objective.name]["objective"] = objective_name(self.own)
        self.history[objective.name] = done.history
        if not self.team.leads:
            return
        save_checkpoint(self.out, self.checkpoint)
        write_text(self.history_file, json.dumps(self.history, indent=1, sort_keys=True, allow_nan=False) + "\n")


def _short_hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]
