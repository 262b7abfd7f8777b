"""Layers that both networks are made of.

Letters in shapes: B batch, C channels, H rows, W columns.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import torch
from torch import Tensor, nn

from ncmodel.nets.presets import Blocks

WIDE = 32
"""Networks of at least so many channels keep all threads busy."""


@contextmanager
def threads_for(width: int) -> Iterator[None]:
    """One thread in the block for a narrow network, whose many small steps else wait for each other's threads.

    On two busy cores, a search with the tiny preset took 1.7 s on one thread and 45 s on two.
    """
    before = torch.get_num_threads()
    torch.set_num_threads(1 if width < WIDE else before)
    try:
        yield
    finally:
        torch.set_num_threads(before)


class Standardise(nn.Module):
    """Brings each input channel to background 0 and a root mean square of about 1.

    Zero is what convolutions pad with, so a picture's surroundings look like more background. The scales are buffers:
    they are measured on the training views and travel with the weights.

    Attributes:
        background: (C,) value of each channel where nothing is seen.
        scale: (C,) divisor.
    """

    background: Tensor
    scale: Tensor

    def __init__(self, background: list[float]) -> None:
        super().__init__()
        self.register_buffer("background", torch.tensor(background))
        self.register_buffer("scale", torch.ones(len(background)))

    def fit(self, images: Tensor) -> None:
        """Measure the scales on (B, C, H, W) images; channels that are all background get 1."""
        scale = (images - self.background[:, None, None]).square().mean(dim=(0, 2, 3)).sqrt()
        self.scale.copy_(torch.where(scale > 1e-6, scale, torch.ones_like(scale)))

    def forward(self, image: Tensor) -> Tensor:
        """(B, C, H, W) -> (B, C, H, W)."""
        return (image - self.background[:, None, None]) / self.scale[:, None, None]


class Pick(nn.Module):
    """The channels that a network reads, of the maps that are handed on for all networks.

    Args:
        given: Names of the maps that are handed on; None if they are those that are read.
        inputs: Names of the maps that are read.

    Attributes:
        given: Names of the maps that are handed on.
    """

    def __init__(self, given: tuple[str, ...] | None, inputs: tuple[str, ...]) -> None:
        super().__init__()
        self.given = inputs if given is None else given
        self.channels = None if self.given == inputs else [self.given.index(name) for name in inputs]

    def forward(self, maps: Tensor) -> Tensor:
        """(B, given, H, W) -> (B, inputs, H, W)."""
        return maps if self.channels is None else maps[:, self.channels]


def conv_norm(inputs: int, outputs: int, kernel: int, stride: int = 1, style: Blocks = "resnet") -> nn.Sequential:
    """Convolution, then batch norm.

    Batch norm makes the convolution's bias superfluous; pix2pixHD has one all the same, and reflects the picture at its
    rim where the stride is 1.

    (B, inputs, H, W) -> (B, outputs, ceil(H / stride), ceil(W / stride)).
    """
    mirrored = style == "pix2pixhd" and stride == 1
    convolution = nn.Conv2d(
        inputs,
        outputs,
        kernel,
        stride,
        padding=kernel // 2,
        bias=style == "pix2pixhd",
        padding_mode="reflect" if mirrored else "zeros",
    )
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs))


class ResidualBlock(nn.Module):
    """Two 3x3 convolutions with batch norm beside a shortcut, ReLU between them.

    In the style of He et al. 2016 there is a ReLU after the sum too; in pix2pixHD's (Wang et al. 2018) there isn't.

    The shortcut is a 1x1 convolution with batch norm where the shape changes, else the identity. A strided 1x1
    convolution sees only every other pixel; taking those first is the same, and steers clear of oneDNN's strided 1x1
    kernel, whose gradient writes outside its buffers for narrow channels-last inputs (8 channels of 48 x 48 in
    torch 2.13).

    (B, inputs, H, W) -> (B, outputs, ceil(H / stride), ceil(W / stride)).
    """

    def __init__(self, inputs: int, outputs: int, stride: int = 1, style: Blocks = "resnet") -> None:
        super().__init__()
        self.stride, self.style = stride, style
        self.first = conv_norm(inputs, outputs, 3, stride, style)
        self.second = conv_norm(outputs, outputs, 3, style=style)
        same = inputs == outputs and stride == 1
        self.shortcut = nn.Identity() if same else conv_norm(inputs, outputs, 1, style=style)

    def forward(self, x: Tensor) -> Tensor:
        """Apply the block."""
        beside = self.shortcut(x[:, :, :: self.stride, :: self.stride])
        total = self.second(torch.relu(self.first(x))) + beside
        return total if self.style == "pix2pixhd" else torch.relu(total)


def residual_stages(width: int, blocks: Sequence[int]) -> nn.ModuleList:
    """The stages of a ResNet: the first of `width` channels, each later one of twice as many at half the resolution.

    Args:
        width: Channels that come in, and of the first stage.
        blocks: How many residual blocks each stage has.
    """
    stages, inputs = [], width
    for index, count in enumerate(blocks):
        outputs = width * 2**index
        first = ResidualBlock(inputs, outputs, stride=1 if index == 0 else 2)
        stages.append(nn.Sequential(first, *(ResidualBlock(outputs, outputs) for _ in range(count - 1))))
        inputs = outputs
    return nn.ModuleList(stages)


def initialise(network: nn.Module, generator: torch.Generator) -> None:
    """Draw all weights anew: He et al. 2015 for convolutions, the usual ones for the rest.

    The last batch norm of every residual block starts at 0, so that a deep stack starts as the identity (Goyal et al.
    2017); with the few steps of a small training set that is what lets 19 blocks train at all.
    """
    for module in network.modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            nn.init.kaiming_normal_(module.weight, mode="fan_in", nonlinearity="relu", generator=generator)
            if module.bias is not None:
                nn.init.zeros_(module.bias)
        elif isinstance(module, nn.BatchNorm2d):
            nn.init.ones_(module.weight)
            nn.init.zeros_(module.bias)
        elif isinstance(module, nn.Linear):
            nn.init.normal_(module.weight, std=module.in_features**-0.5, generator=generator)
            if module.bias is not None:
                nn.init.zeros_(module.bias)
    for block in network.modules():
        if isinstance(block, ResidualBlock):
            norm = block.second[1]
            assert isinstance(norm, nn.BatchNorm2d)
            nn.init.zeros_(norm.weight)
