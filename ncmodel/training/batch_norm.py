"""What batch norm goes by while a network learns: a part's own statistics, those of all processes, or the running ones.

With a step cut into parts, statistics of its own are noisier, and the step isn't quite the whole one any more; the
running ones don't depend on how steps are cut.
"""

from typing import Any, Literal

import torch
from torch import Tensor, distributed, nn

BatchNorm = Literal["own", "synchronised", "frozen"]
BATCH_NORMS: tuple[BatchNorm, ...] = ("own", "synchronised", "frozen")


class _Total(torch.autograd.Function):
    """The sum over all processes, to which each contributes, so that each gets the sum of all gradients back."""

    @staticmethod
    def forward(_: Any, mine: Tensor) -> Tensor:
        """The sum of all processes' tensors."""
        total = mine.clone()
        distributed.all_reduce(total)
        return total

    @staticmethod
    def backward(_: Any, gradient: Tensor) -> Tensor:
        """The sum of all processes' gradients."""
        total = gradient.clone()
        distributed.all_reduce(total)
        return total


def _total(mine: Tensor) -> Tensor:
    found: Tensor = _Total.apply(mine)  # type: ignore[no-untyped-call]
    return found


class SynchronisedBatchNorm2d(nn.BatchNorm2d):
    """Batch norm by the mean and variance over what all processes look at; on any device, where torch's needs a GPU."""

    def forward(self, x: Tensor) -> Tensor:
        """(B, C, H, W) -> (B, C, H, W); every process has to take part."""
        if not self.training:
            return super().forward(x)
        # In float32 within autocast too: sums over many pixels need the digits.
        with torch.autocast(x.device.type, enabled=False):
            wide = x.float()
            count = torch.full_like(self.weight, x.numel() / x.shape[1])
            totals = _total(torch.stack([wide.sum(dim=(0, 2, 3)), count]))
            mean, count = totals[0] / totals[1], totals[1].detach()
            centred = wide - mean[:, None, None]
            variance = _total(centred.square().sum(dim=(0, 2, 3))) / count
            self._run(mean.detach(), (variance * count / (count - 1)).detach())
            scale = self.weight * torch.rsqrt(variance + self.eps)
            return (centred * scale[:, None, None] + self.bias[:, None, None]).to(x.dtype)

    @torch.no_grad()
    def _run(self, mean: Tensor, variance: Tensor) -> None:
        """Update the running statistics."""
        assert self.running_mean is not None
        assert self.running_var is not None
        assert self.num_batches_tracked is not None
        assert self.momentum is not None
        self.running_mean.lerp_(mean, self.momentum)
        self.running_var.lerp_(variance, self.momentum)
        self.num_batches_tracked += 1


def synchronise(network: nn.Module) -> None:
    """Make all batch norms of a network synchronised ones, in place, with the weights and buffers that they have."""
    for module in list(network.modules()):
        for name, child in module.named_children():
            if type(child) is nn.BatchNorm2d:
                other = SynchronisedBatchNorm2d(child.num_features, child.eps, child.momentum)
                other.load_state_dict(child.state_dict())
                other.to(child.weight.device).train(child.training)
                module.add_module(name, other)


def freeze(network: nn.Module) -> None:
    """Make all batch norms go by their running statistics and leave these; gains and biases still learn."""
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.eval()
