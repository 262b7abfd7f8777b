"""The published networks, filter and ridge detector, written plainly from what is known of them, as a reference.

Nothing of ours is used, so that a mistake can't be on both sides. Widths are free: a narrow network is quick.
"""

from collections.abc import Sequence

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor, nn

from ncmodel.types import Floats, Image, Mask

SHADED_MEAN, DEPTH_MEAN = 0.974258, 0.906764


class Basic(nn.Module):
    """ResNet's basic block."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(outputs)
        if inputs != outputs or stride != 1:
            shortcut = nn.Conv2d(inputs, outputs, 1, stride, bias=False)
            self.downsample = nn.Sequential(shortcut, nn.BatchNorm2d(outputs))

    def forward(self, x: Tensor) -> Tensor:
        y = self.bn2(self.conv2(torch.relu(self.bn1(self.conv1(x)))))
        return torch.relu(y + (self.downsample(x) if hasattr(self, "downsample") else x))


class Ranking(nn.Module):
    """ResNet-34 with a fifth stage over drawing, first shaded map and depth. Lower is better."""

    def __init__(self, width: int = 64, blocks: Sequence[int] = (3, 4, 6, 3, 3)) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, width, 7, 2, 3, bias=False)
        self.bn1 = nn.BatchNorm2d(width)
        self.maxpool = nn.MaxPool2d(3, 2, 1)
        inputs, self.stages = width, len(blocks)
        for number, count in enumerate(blocks, 1):
            outputs = width * 2 ** (number - 1)
            layer = [Basic(inputs, outputs, 1 if number == 1 else 2)]
            layer += [Basic(outputs, outputs, 1) for _ in range(count - 1)]
            setattr(self, f"layer{number}", nn.Sequential(*layer))
            inputs = outputs
        self.fc = nn.Linear(inputs, 1)

    def forward(self, x: Tensor) -> Tensor:
        x = self.maxpool(torch.relu(self.bn1(self.conv1(x))))
        for number in range(1, self.stages + 1):
            x = getattr(self, f"layer{number}")(x)
        return torch.as_tensor(self.fc(x.flatten(2).mean(dim=2)))


class Residual(nn.Module):
    """pix2pixHD's block."""

    def __init__(self, width: int) -> None:
        super().__init__()
        half = [nn.ReflectionPad2d(1), nn.Conv2d(width, width, 3), nn.BatchNorm2d(width)]
        other = [nn.ReflectionPad2d(1), nn.Conv2d(width, width, 3), nn.BatchNorm2d(width)]
        self.conv_block = nn.Sequential(*half, nn.ReLU(), *other)

    def forward(self, x: Tensor) -> Tensor:
        return x + torch.as_tensor(self.conv_block(x))


class Translation(nn.Module):
    """pix2pixHD's global generator over six shaded maps and depth; near 1 is background."""

    def __init__(self, width: int = 64, levels: int = 4, blocks: int = 9) -> None:
        super().__init__()
        parts: list[nn.Module] = [nn.ReflectionPad2d(3), nn.Conv2d(7, width, 7), nn.BatchNorm2d(width), nn.ReLU()]
        for level in range(levels):
            low, high = width << level, width << (level + 1)
            parts += [nn.Conv2d(low, high, 3, 2, 1), nn.BatchNorm2d(high), nn.ReLU()]
        parts += [Residual(width << levels) for _ in range(blocks)]
        for level in reversed(range(levels)):
            low, high = width << level, width << (level + 1)
            parts += [nn.ConvTranspose2d(high, low, 3, 2, 1, output_padding=1), nn.BatchNorm2d(low), nn.ReLU()]
        parts += [nn.ReflectionPad2d(3), nn.Conv2d(width, 1, 7), nn.Sigmoid()]
        self.model = nn.Sequential(*parts)

    def forward(self, x: Tensor) -> Tensor:
        return torch.as_tensor(self.model(x))


def randomise(network: nn.Module, seed: int) -> nn.Module:
    """Random weights and batch-norm statistics, none at its default, whose outputs keep a moderate size."""
    generator = torch.Generator().manual_seed(seed)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            for tensor, mean, spread in (
                (module.weight, 0.8, 0.2),
                (module.bias, 0.05, 0.2),
                (module.running_mean, 0.1, 0.3),
            ):
                assert tensor is not None
                tensor.data.normal_(mean, spread, generator=generator)
            assert module.running_var is not None
            module.running_var.uniform_(0.5, 2.0, generator=generator)
        elif isinstance(module, nn.Conv2d | nn.ConvTranspose2d | nn.Linear):
            inputs = module.weight[0].numel() if not isinstance(module, nn.ConvTranspose2d) else module.weight.shape[0]
            module.weight.data.normal_(0.0, (2.0 / inputs) ** 0.5, generator=generator)
            if module.bias is not None:
                module.bias.data.normal_(0.0, 0.1, generator=generator)
    return network.eval().requires_grad_(False)


def stored(values: Image) -> Floats:
    """What a 16-bit picture holds, in double precision."""
    return np.rint(values.astype(np.float64) * 65535) / 65535


def translation_input(shaded: Image, depth: Image) -> Tensor:
    """(1, 7, H, W) of six shaded maps and depth, which come from 16 bits."""
    stack = np.concatenate([stored(shaded) - SHADED_MEAN, stored(depth)[None] - DEPTH_MEAN])
    return torch.from_numpy(stack)[None].float()


def drawing(
    lines: Image, features: Image, facing: Image, base: Image, p90: Floats, size: float, thresholds: Tensor
) -> Tensor:
    """(H, W) I(t) pixel by pixel: rtsc's fade of suggestive contours, and 1 - t / (fs^n k) of the others."""
    value = torch.from_numpy(stored(features) * p90[:, None, None]).to(thresholds.dtype)
    ink, cosine = (torch.from_numpy(part).to(thresholds.dtype) for part in (lines, facing))
    t = thresholds.clamp(0, 5)
    excess = torch.clamp(value[0] * size * size - t[0] * cosine, min=0)
    shown = [excess / (0.03 * cosine + excess + 1e-12) * ink[0]]
    for number, power in ((1, 1), (2, 1), (3, 2)):
        scale = torch.tensor(size, dtype=thresholds.dtype) ** power
        strength = value[number] * scale
        faded = 1 - t[number] / (strength + 1e-12)
        shown.append(faded.clamp(0, 1) * ink[number])
    return torch.stack([*shown, torch.from_numpy(base).to(thresholds.dtype)]).max(dim=0).values.clamp(0, 1)


def ranking_score(network: nn.Module, drawn: Tensor, shaded: Image, depth: Image) -> Tensor:
    """() what the ranking module says of a (768, 1024) drawing in the middle of 1024 x 1024; lower is better."""
    whole = torch.zeros(1, 3, 1024, 1024, dtype=drawn.dtype)
    whole[:, 1], whole[:, 2] = 1 - SHADED_MEAN, 1 - DEPTH_MEAN
    whole[0, 1, 128:896] = torch.from_numpy(stored(shaded) - SHADED_MEAN)
    whole[0, 2, 128:896] = torch.from_numpy(stored(depth) - DEPTH_MEAN)
    padded = nn.functional.pad(drawn, (0, 0, 128, 128))
    return torch.as_tensor(network(torch.cat([padded[None, None], whole[:, 1:]], dim=1)))[0, 0]


def ridge_pixels(paper: Image) -> Mask:
    """(H, W) pixels of lines in the image branch's output."""
    levels = np.floor(paper * np.float32(255)).astype(np.uint8)
    bright = np.where(levels >= 220, 255, levels) / 255.0
    smooth = ndimage.gaussian_filter(bright, 3.7, mode="constant", cval=0.0)
    down, across = np.gradient(smooth)
    hyy, hyx = np.gradient(down)
    _, hxx = np.gradient(across)
    matrices = np.stack([hyy, hyx, hyx, hxx], axis=-1).reshape(*paper.shape, 2, 2)
    valley = np.linalg.eigvalsh(matrices)[..., 1] >= 0.0015
    return np.asarray(ndimage.binary_erosion(valley, np.ones((5, 5)), border_value=1))
