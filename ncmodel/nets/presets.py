"""Every number of the networks' architecture and training, in one place.

`paper` is the paper's layer tables and rates. `small` and `tiny` are the same architecture, narrower and on smaller
pictures, for machines without a GPU. They halve the resolution less often, so that pictures end in about as many cells
as the paper's do (48 x 48 in the image branch, 12 x 12 in the ranking module). In 16 x 16 cells the image branch can't
tell to the pixel where lines run, and 2 x 2 cells leave the ranking module little but padding to look at. They train at
higher rates, because a narrow network with few steps needs and stands them.
"""

import json
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, Self

from ncmodel.errors import ArgumentError

MAPS = ("depth", *(f"shaded_{level}" for level in range(6)))
"""Depth and six shaded maps: what both networks read in the paper, in the order of their channels."""

CURVATURE_MAPS = ("suggestive", "ridges", "valleys", "apparent")
"""What filters these families, over its 90th percentile and clipped to 0..1: apparent ridges' q1 reaches 1e6 of them at
contours. The paper's variant NC-image-curv reads them too."""

BACKGROUND = 1.0
"""What every map is where no surface is seen. Drawings are 0 there."""

MOST_PIXELS = 4096
MOST_CHANNELS = 1 << 14
MOST_BLOCKS = 256
MOST_NUMBERS = 1 << 16
"""Files name the networks that are built to read them: what is larger than these is damaged or meant to hang. Sides of
pictures; channels; residual blocks, or networks that vote; inputs, outputs and hidden units of networks on numbers. The
paper's preset has 768, 1024 and 19."""

Blocks = Literal["resnet", "pix2pixhd"]
Percentile = Literal["view", "mesh"]


@dataclass(frozen=True)
class TranslationDims:
    """Architecture of the image translation branch.

    Attributes:
        size: Side of the square input and output, pixels; a multiple of 2^levels.
        width: Channels after the first convolution; every stride-2 convolution doubles them.
        levels: Number of stride-2 convolutions down, and of stride-1/2 convolutions up.
        blocks: Residual blocks in between.
        inputs: Names of the maps that are read, of `MAPS` and `CURVATURE_MAPS`, in the order of the channels.
        style: "pix2pixhd" has the blocks of Wang et al. 2018, which the paper follows: no ReLU after the sum,
            reflection padding in convolutions of stride 1, and a bias before batch norm. "resnet" has those of He et
            al. 2016 and pads with background.
    """

    size: int = 768
    width: int = 64
    levels: int = 4
    blocks: int = 9
    inputs: tuple[str, ...] = MAPS
    style: Blocks = "resnet"

    def __post_init__(self) -> None:
        _check_inputs(self.inputs)
        if self.style not in ("resnet", "pix2pixhd"):
            raise ValueError(f"style is {self.style!r}, expected resnet or pix2pixhd")
        _check_most(MOST_PIXELS, size=self.size)
        _check_most(MOST_BLOCKS, blocks=self.blocks, levels=self.levels)
        if min(self.size, self.width, self.levels) < 1 or self.blocks < 0 or self.size % 2**self.levels:
            raise ValueError(f"{self}: expected positive numbers and a size divisible by {2**self.levels}")
        _check_most(MOST_CHANNELS, channels=self.width * 2**self.levels)


@dataclass(frozen=True)
class RankingDims:
    """Architecture of the neural ranking module.

    Attributes:
        size: Side of the square input, pixels.
        width: Channels of the first convolution and the first stage; every later stage doubles them.
        blocks: Residual blocks of each stage: in the paper, ResNet-34's four and one more. Each stage but the first
            halves the resolution.
        inputs: Names of the maps that are read beside the drawing, as `TranslationDims` has them.
    """

    size: int = 768
    width: int = 64
    blocks: tuple[int, ...] = (3, 4, 6, 3, 3)
    inputs: tuple[str, ...] = MAPS

    def __post_init__(self) -> None:
        _check_inputs(self.inputs)
        if self.size < 1 or self.width < 1 or not self.blocks or min(self.blocks) < 1:
            raise ValueError(f"{self}: expected positive numbers")
        _check_most(MOST_PIXELS, size=self.size)
        _check_most(MOST_BLOCKS, blocks=sum(self.blocks))
        _check_most(MOST_CHANNELS, channels=self.width * 2 ** (len(self.blocks) - 1))


def _check_most(most: int, **found: int) -> None:
    for name, value in found.items():
        if value > most:
            raise ValueError(f"{name} is {value}, expected at most {most}")


def _check_inputs(inputs: tuple[str, ...]) -> None:
    known = (*MAPS, *CURVATURE_MAPS)
    if not inputs or not set(inputs) <= set(known) or len(set(inputs)) < len(inputs):
        raise ValueError(f"inputs are {inputs}, expected different ones of {', '.join(known)}")


@dataclass(frozen=True)
class StatisticsDims:
    """Architecture of the ranker on numbers.

    Attributes:
        numbers: Of each drawing.
        settings: That drawings are chosen among.
        width: Hidden units of each network.
        networks: How many vote.
        dropout: Share of the numbers that a network doesn't see in a training step.
    """

    numbers: int = 149
    settings: int = 256
    width: int = 48
    networks: int = 8
    dropout: float = 0.2

    def __post_init__(self) -> None:
        if min(self.numbers, self.settings, self.width, self.networks) < 1 or not 0.0 <= self.dropout < 1.0:
            raise ValueError(f"{self}: expected positive numbers and a share")
        _check_most(MOST_NUMBERS, numbers=self.numbers, settings=self.settings, width=self.width)
        _check_most(MOST_BLOCKS, networks=self.networks)


@dataclass(frozen=True)
class Rates:
    """How one training stage runs.

    Attributes:
        learning_rate: Adam's.
        batch: Ranking pairs (ranker, finetune) or views (translator) a step.
        epochs: Passes over the training pairs when the command gives no other number.
    """

    learning_rate: float
    batch: int
    epochs: int


@dataclass(frozen=True)
class Variation:
    """How training views are varied, their drawings with them, each time they are seen.

    Attributes:
        mirror: Mirror half of them left to right.
        quarter_turns: Turn them by a random multiple of 90 degrees.
        shift: Move them by up to this share of their side; cameras leave 0.06 empty.
    """

    mirror: bool = True
    quarter_turns: bool = False
    shift: float = 0.04


@dataclass(frozen=True)
class Preset:
    """A named pair of networks and how they are trained.

    Attributes:
        averaging: The weights that are judged and kept are an exponential moving average over steps with this decay; 0
            keeps the last ones, as the paper does. Weights trained on few data at high rates jump about from step to
            step; their average generalises better and steadily.
        statistics: The ranker on plain numbers, which the paper doesn't have; None does without.
        counting: How it is trained.
        percentile: What thresholds and curvature maps are measured in: the 90th percentile over the pixels of the
            "view", or over the vertices of the whole "mesh", seen or not, as the paper's text says.
        published: Networks of the published checkpoints: unless told otherwise, they draw as the published code does.
    """

    name: str
    translation: TranslationDims
    ranking: RankingDims
    ranker: Rates
    translator: Rates
    finetune: Rates
    variation: Variation = field(default_factory=Variation)
    averaging: float = 0.0
    statistics: StatisticsDims | None = None
    counting: Rates = field(default_factory=lambda: Rates(3e-4, batch=64, epochs=30))
    percentile: Percentile = "view"
    published: bool = False

    def __post_init__(self) -> None:
        if self.percentile not in ("view", "mesh"):
            raise ValueError(f"percentile is {self.percentile!r}, expected view or mesh")
        if self.translation.size % self.ranking.size:
            # Finetuning averages the image branch's output down to what the ranking module reads.
            raise ValueError(f"sizes {self.translation.size} and {self.ranking.size}: expected a multiple and its part")

    def to_record(self) -> dict[str, Any]:
        """The preset as JSON's own types, for checkpoint headers."""
        record: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return record

    @property
    def inputs(self) -> tuple[str, ...]:
        """The maps of a view that any of the networks reads: what is computed, read and handed on, in this order."""
        read = {*self.translation.inputs, *self.ranking.inputs, *(MAPS if self.statistics else ())}
        return tuple(name for name in (*MAPS, *CURVATURE_MAPS) if name in read)

    @property
    def stages(self) -> tuple[str, ...]:
        """What is trained, in order: each stage is named after what it trains."""
        return ("ranker", "translator", "finetune", *(["statistics"] if self.statistics else []))

    def rates(self, stage: str) -> Rates:
        """How a stage runs. The paper has no rates of the regressor's: it learns from drawings, as the translator."""
        rates: Rates = getattr(self, {"statistics": "counting", "regressor": "translator"}.get(stage, stage))
        return rates

    @classmethod
    def from_record(cls, record: dict[str, Any]) -> Self:
        """The inverse of `to_record`.

        Raises:
            KeyError, TypeError, ValueError: A key is missing or unknown, or a value makes no sense.
        """
        parts: dict[str, Any] = dict(record)
        parts["ranking"] = RankingDims(**_tuples(parts.pop("ranking")))
        parts["translation"] = TranslationDims(**_tuples(parts.pop("translation")))
        parts["variation"] = Variation(**parts.pop("variation"))
        if parts.get("statistics") is not None:
            parts["statistics"] = StatisticsDims(**parts["statistics"])
        for stage in {"ranker", "translator", "finetune", "counting"} & set(parts):
            parts[stage] = Rates(**parts.pop(stage))
        return cls(**parts)


def _tuples(record: dict[str, Any]) -> dict[str, Any]:
    """JSON's lists as the tuples that they were."""
    return {key: tuple(value) if isinstance(value, list) else value for key, value in record.items()}


PRESETS = {
    preset.name: preset
    for preset in (
        Preset(
            "paper",
            TranslationDims(style="pix2pixhd"),
            RankingDims(),
            ranker=Rates(2e-5, batch=32, epochs=20),
            translator=Rates(2e-4, batch=2, epochs=20),
            finetune=Rates(2e-5, batch=32, epochs=2),
        ),
        Preset(
            "small",
            TranslationDims(size=384, width=16, levels=3),
            RankingDims(size=192, width=16, blocks=(3, 4, 6)),
            ranker=Rates(1e-3, batch=32, epochs=48),
            translator=Rates(1e-3, batch=2, epochs=12),
            finetune=Rates(2e-5, batch=32, epochs=2),
            variation=Variation(quarter_turns=True),
            averaging=0.98,
            statistics=StatisticsDims(),
        ),
        Preset(
            "tiny",
            TranslationDims(size=256, width=8, levels=2),
            RankingDims(size=64, width=16, blocks=(3, 4)),
            ranker=Rates(3e-3, batch=16, epochs=96),
            translator=Rates(2e-3, batch=2, epochs=10),
            finetune=Rates(2e-5, batch=32, epochs=1),
            variation=Variation(quarter_turns=True),
            averaging=0.98,
            statistics=StatisticsDims(),
        ),
    )
}


def preset_named(preset: str) -> Preset:
    """A preset by name.

    Raises:
        UsageError: There is none of that name.
    """
    if preset not in PRESETS:
        raise ArgumentError("preset", repr(preset), f"one of {', '.join(PRESETS)}")
    return PRESETS[preset]
