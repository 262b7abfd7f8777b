"""Training, from a data folder and ranking pairs to a checkpoint.

Beside CHECKPOINT lie CHECKPOINT.history.json (losses and measures of every pass) and, for each stage that was trained,
CHECKPOINT.STAGE.state (what it needs to go on).
"""

import copy
import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
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
from ncmodel.nets.checkpoints import Checkpoint, load_checkpoint, save_checkpoint
from ncmodel.nets.devices import device_named
from ncmodel.nets.presets import Preset
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.statistics_ranker import StatisticsRanker
from ncmodel.nets.translation import TranslationBranch
from ncmodel.parsing import parse_json
from ncmodel.progress import Progress, silent
from ncmodel.training.dataset import ViewImages, read_training_pairs
from ncmodel.training.loop import STAGES, Plan, Progressed, fit
from ncmodel.training.objectives import (
    FinetuneObjective,
    Measures,
    Objective,
    RankerObjective,
    TranslatorObjective,
)
from ncmodel.training.statistics import DrawingNumbers, StatisticsObjective, learn_habit, learn_mix

N = TypeVar("N", bound=nn.Module)

TIME_SHARES = {"ranker": 0.5, "translator": 0.33, "finetune": 0.12, "statistics": 0.05}
"""How a budget of seconds is split among the stages that run."""


@dataclass(frozen=True)
class TrainOptions:
    """How to train.

    Attributes:
        stages: Some of "ranker", "translator", "finetune", "statistics", in this order; what the preset has by default.
        epochs: Passes over the data in each stage, those of earlier runs included; the preset's numbers by default.
        seconds: Stop early after this long; the stages get shares of it. How far a machine gets in a time varies, so
            only training without it is reproducible.
        seed: Of initial weights, order and variation.
        restart: Forget an earlier training that wrote to the same place.
        device: Where to compute: "cpu", "cuda", or another of torch's devices.
    """

    stages: tuple[str, ...] | None = None
    epochs: int | None = None
    seconds: float | None = None
    seed: int = 0
    restart: bool = False
    device: str = "cpu"

    def __post_init__(self) -> None:
        if self.stages is not None and not (self.stages and set(self.stages) <= set(STAGES)):
            raise ArgumentError("stages", repr(",".join(self.stages)), f"all or one of {', '.join(STAGES)}")
        if self.epochs is not None and self.epochs < 1:
            raise ArgumentError("epochs", str(self.epochs), "at least 1")
        if self.seconds is not None and not self.seconds > 0:
            raise ArgumentError("seconds", str(self.seconds), "a positive number")
        if self.seed < 0:
            raise ArgumentError("seed", str(self.seed), "0 or more")
        device_named(self.device)


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
    """

    checkpoint: str
    preset: str
    pairs: dict[str, int]
    stages: list[StageReport]
    history: dict[str, list[dict[str, Any]]]

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
) -> TrainReport:
    """Train some stages; write checkpoint, history and states. What an earlier run has done already is not done again.

    Args:
        data: DATA_DIR.
        pairs: pairs.jsonl.
        out: Checkpoint to write. Networks in it that the stages don't train are kept.
        preset: Which networks, and their rates.
        options: How to train.
        progress: Is told about every pass.

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
    if options.stages is not None and not set(options.stages) <= set(preset.stages):
        raise ArgumentError(
            "stages", repr(",".join(options.stages)), f"what {preset.name!r} has: {', '.join(preset.stages)}"
        )
    run = _Run(Path(out), preset, options, images, read)
    for name in run.stages:
        run.stage(name, progress)
    return TrainReport(str(out), preset.name, run.counts, run.reports, run.history)


class _Run:
    """One call of `run_training`: the networks so far, and what its stages have reported."""

    def __init__(
        self, out: Path, preset: Preset, options: TrainOptions, images: ViewImages, pairs: Sequence[Pair]
    ) -> None:
        self.out, self.preset, self.options, self.images, self.pairs = out, preset, options, images, pairs
        self.stages = options.stages or preset.stages
        splits = [pair.split for pair in pairs]
        self.counts = {split: splits.count(split) for split in ("train", "validation")}
        self.reports: list[StageReport] = []
        self.history: dict[str, list[dict[str, Any]]] = {}
        self.history_file = out.with_name(f"{out.name}.history.json")
        self.checkpoint = Checkpoint(preset)
        if out.exists() and not (options.restart and self.stages == preset.stages):
            self._take_over()
        if options.restart:
            for name in self.stages:
                self._forget(name)

    @cached_property
    def _pictures(self) -> str:
        """What the pairs show: drawings and maps that were made again aren't those that an earlier run learnt from."""
        return self.images.checksum(self.pairs)[:8]

    @property
    def records(self) -> dict[str, Any]:
        """What the checkpoint says about the stages that made it."""
        stages: dict[str, Any] = self.checkpoint.training.setdefault("stages", {})
        return stages

    def state_file(self, stage: str) -> Path:
        """Where a stage keeps what it needs to go on."""
        return self.out.with_name(f"{self.out.name}.{stage}.state")

    def stage(self, name: str, progress: Progress) -> None:
        """Run one stage to its end and write the checkpoint."""
        begin = time.monotonic()
        objective = self._objective(name, progress)
        # The image branch doubles its few channels four times: its inner layers are wide enough for all threads.
        width = WIDE if name == "translator" else self.preset.ranking.width
        with threads_for(width):
            done = fit(objective, self._plan(name), progress)
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
            raise InputError(self.out, found, f"preset {self.preset.name!r}, or a file that isn't there yet")
        if self.history_file.exists():
            try:
                self.history = parse_json(self.history_file.read_text(encoding="utf-8"))
            except ValueError as error:
                raise InputError(
                    self.history_file, f"not JSON ({error})", "what training wrote, or no such file"
                ) from error

    def _forget(self, stage: str) -> None:
        if stage == "statistics":
            self.checkpoint.statistics = None
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
        rates = self.preset.rates(stage)
        seconds = self.options.seconds
        if seconds is not None:
            seconds *= TIME_SHARES[stage] / sum(TIME_SHARES[name] for name in self.stages)
        return Plan(self.state_file(stage), settings, self.options.epochs or rates.epochs, self.options.seed, seconds)

    def _objective(self, stage: str, progress: Progress) -> Objective:
        """What a stage trains: new networks, which `fit` brings to where their state says, or those to finetune."""
        shared = (self.images, self.pairs)
        if stage == "statistics":
            assert self.preset.statistics is not None, "else it isn't among the preset's stages"
            counting = self._new(StatisticsRanker(self.preset.statistics), stage, "cpu")
            return StatisticsObjective(self.preset, counting, DrawingNumbers(self.images.data), self.pairs, progress)
        if stage == "ranker":
            ranker = RankingModule(self.preset.ranking, self.preset.inputs)
            return RankerObjective(self.preset, self._new(ranker, stage), *shared)
        if stage == "translator":
            translator = TranslationBranch(self.preset.translation, self.preset.inputs)
            return TranslatorObjective(self.preset, self._new(translator, stage), *shared)
        trained = copy.deepcopy(self.checkpoint)
        for network in trained.networks.values():
            network.to(self.options.device)
        if trained.ranker is None or trained.translator is None:
            missing = "ranker" if trained.ranker is None else "translator"
            raise UsageError(f"{self.out}: finetuning needs both networks; train the {missing} first")
        return FinetuneObjective(self.preset, trained.ranker, trained.translator, *shared)

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
        return network.to(device or self.options.device)

    def _keep(self, objective: Objective, done: Progressed) -> None:
        """Put a stage's networks into the checkpoint. What was trained on earlier ones is void."""
        for name, network in objective.networks.items():
            setattr(self.checkpoint, name, network)
        for later in STAGES[max(STAGES.index(objective.name) + 1, STAGES.index("finetune")) :]:
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
        self.history[objective.name] = done.history
        save_checkpoint(self.out, self.checkpoint)
        write_text(self.history_file, json.dumps(self.history, indent=1, sort_keys=True, allow_nan=False) + "\n")


def _short_hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]
