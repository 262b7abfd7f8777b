"""pix2pixHD as an objective: the image branch's network learns to draw what discriminators take for real.

`--objective pix2pixhd` trains it in the place of the translator's cross-entropy, which has no part in it. Generator and
discriminators take their steps at the same time, from one loss: each part reaches the weights of one of them alone.
pix2pixHD's Adam forgets faster (beta1 0.5); here it is the other stages'.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.func import functional_call

from ncmodel.data.pairs import Pair
from ncmodel.nets.blocks import initialise
from ncmodel.nets.devices import device_of
from ncmodel.nets.discriminators import MultiScaleDiscriminator, feature_matching, least_squares
from ncmodel.nets.presets import Preset
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.batches import Batch
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Examiner
from ncmodel.training.objectives import TranslatorObjective
from ncmodel.training.state import Measures

MATCHING = 10.0
"""How much feature matching counts beside the adversarial loss (lambda of Wang et al. 2018)."""


class Pix2pixHDObjective(TranslatorObjective):
    """LSGAN and feature matching on each view's best drawing; no cross-entropy."""

    def __init__(
        self, preset: Preset, translator: TranslationBranch, images: ViewImages, pairs: Sequence[Pair]
    ) -> None:
        super().__init__(preset, translator, images, pairs)
        self.discriminator = MultiScaleDiscriminator(translator.dims, preset.inputs)
        # The generator's weights tell trainings apart; discriminators all start alike.
        initialise(self.discriminator, torch.Generator().manual_seed(0))
        self.discriminator.to(device_of(translator))
        self.networks: dict[str, nn.Module] = {"translator": translator, "discriminator": self.discriminator}

    def prepare(self) -> None:
        """Measure the input scales and the share of ink."""
        super().prepare()
        self.discriminator.standardise.load_state_dict(self.translator.standardise.state_dict())

    def loss(self, batch: Batch) -> Tensor:
        """The generator's and the discriminators' losses, added."""
        drawn = self.translator(batch.maps)
        return self.generator_loss(batch, drawn) + self.discriminator_loss(batch, drawn)

    def generator_loss(self, batch: Batch, drawn: Tensor) -> Tensor:
        """What the generator's (B, 1, H, W) drawings lack; discriminators judge, but don't learn from it."""
        fixed = {name: weights.detach() for name, weights in self.discriminator.named_parameters()}
        said = functional_call(self.discriminator, fixed, (batch.maps, drawn))
        with torch.no_grad():
            real = self.discriminator(batch.maps, batch.drawings)
        return least_squares(said, 1.0) + MATCHING * feature_matching(said, real)

    def discriminator_loss(self, batch: Batch, drawn: Tensor) -> Tensor:
        """How badly discriminators tell real drawings from those of the generator, which doesn't learn from it."""
        made = least_squares(self.discriminator(batch.maps, drawn.detach()), 0.0)
        return (made + least_squares(self.discriminator(batch.maps, batch.drawings), 1.0)) / 2

    def validate(self, examiner: Examiner) -> Measures:
        """Nothing: what discriminators say can't be compared between passes, so the last pass is kept."""
        return {}
