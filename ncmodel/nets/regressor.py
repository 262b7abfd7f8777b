"""The appendix's Geometry-Regressor: a network that predicts the thresholds t of a view (appendix 4).

A mesh encoder and an image encoder make a vector each, as long as 16 times the preset's width (1024 in the paper), and
three fully connected layers make t of both. The paper says of the mesh encoder that it is a graph network based on
NeuroSkinning (Liu et al. 2019), and no more: here each of its layers adds, to what a vertex knows, the mean of what its
neighbours know; of all vertices the largest and the mean are taken, so that their order makes no difference. The image
encoder is a ResNet-34 over the maps.

Letters in shapes: B views, V vertices of all their meshes, E pairs of neighbours, K maps.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from ncmodel.nets.blocks import Pick, Standardise, conv_norm, residual_stages
from ncmodel.nets.presets import BACKGROUND, Preset
from ncmodel.types import Floats, Ints

THRESHOLDS = 4
"""t_S, t_R, t_V, t_A."""

RESNET34 = (3, 4, 6, 3)
"""Residual blocks of its stages; small presets have fewer of them."""

KNOWN = 6
"""Of each vertex: position and normal, in object space."""


@dataclass(frozen=True, eq=False)
class MeshGraph:
    """Meshes as graphs, several beside each other.

    Attributes:
        vertices: (V, 6) positions and unit normals.
        neighbours: (2, E) vertices that an edge joins, each edge in both directions.
        first: B + 1 numbers: where each mesh's vertices begin, and V.
    """

    vertices: Tensor
    neighbours: Tensor
    first: tuple[int, ...]

    @staticmethod
    def of(vertices: Floats, normals: Floats, faces: Ints) -> "MeshGraph":
        """The graph of one mesh: (N, 3) positions, (N, 3) normals, (F, 3) vertices of the faces."""
        corners = np.asarray(faces, dtype=np.int64)
        edges = np.concatenate([corners[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
        edges = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
        known = np.concatenate([vertices, normals], axis=1).astype(np.float32)
        return MeshGraph(torch.from_numpy(known), torch.from_numpy(edges.T.copy()), (0, len(known)))

    @staticmethod
    def together(graphs: Sequence["MeshGraph"]) -> "MeshGraph":
        """Several beside each other."""
        first = [0]
        for graph in graphs:
            first += [first[-1] + end for end in graph.first[1:]]
        starts = np.cumsum([0, *(len(graph.vertices) for graph in graphs)])
        neighbours = [graph.neighbours + int(start) for graph, start in zip(graphs, starts, strict=False)]
        return MeshGraph(torch.cat([graph.vertices for graph in graphs]), torch.cat(neighbours, dim=1), tuple(first))

    def on(self, device: torch.device) -> "MeshGraph":
        """The same on a device."""
        return MeshGraph(self.vertices.to(device), self.neighbours.to(device), self.first)


class GraphLayer(nn.Module):
    """What each vertex knows, and the mean of what its neighbours do, through a linear layer each."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.own = nn.Linear(inputs, outputs)
        self.others = nn.Linear(inputs, outputs, bias=False)
        self.norm = nn.LayerNorm(outputs)

    def forward(self, known: Tensor, neighbours: Tensor) -> Tensor:
        """(V, inputs), (2, E) -> (V, outputs)."""
        to, of = neighbours
        told = self.others(known)
        total = torch.zeros_like(told).index_add(0, to, told[of])
        count = torch.zeros(len(known), device=known.device).index_add(0, to, torch.ones_like(to, dtype=torch.float32))
        return torch.relu(self.norm(self.own(known) + total / count.clamp(min=1.0)[:, None]))


class MeshEncoder(nn.Module):
    """Meshes -> (B, outputs), whatever the order of their vertices and faces, to rounding."""

    def __init__(self, width: int, outputs: int) -> None:
        super().__init__()
        widths = [KNOWN, width, 2 * width, 4 * width]
        self.layers = nn.ModuleList(GraphLayer(a, b) for a, b in pairwise(widths))
        self.head = nn.Linear(2 * widths[-1], outputs)

    def forward(self, graph: MeshGraph) -> Tensor:
        """Of each of B meshes, a vector."""
        known = graph.vertices
        for layer in self.layers:
            known = layer(known, graph.neighbours)
        meshes = [known[begin:end] for begin, end in pairwise(graph.first)]
        pooled = [torch.cat([mesh.amax(dim=0), mesh.mean(dim=0)]) for mesh in meshes]
        return torch.relu(self.head(torch.stack(pooled)))


class ImageEncoder(nn.Module):
    """ResNet-34 over the maps: (B, K, H, W) -> (B, outputs)."""

    def __init__(self, preset: Preset, outputs: int) -> None:
        super().__init__()
        dims = preset.ranking
        self.pick = Pick(preset.inputs, dims.inputs)
        self.standardise = Standardise([BACKGROUND] * len(dims.inputs))
        self.stem = conv_norm(len(dims.inputs), dims.width, 7, stride=2)
        self.pool = nn.MaxPool2d(3, stride=2, padding=1)
        blocks = dims.blocks[: len(RESNET34)]
        self.stages = residual_stages(dims.width, blocks)
        self.head = nn.Linear(dims.width * 2 ** (len(blocks) - 1), outputs)

    def forward(self, maps: Tensor) -> Tensor:
        """Of each of B views, a vector."""
        x = self.pool(torch.relu(self.stem(self.standardise(self.pick(maps)))))
        for stage in self.stages:
            x = stage(x)
        return torch.relu(self.head(x.mean(dim=(2, 3))))


class GeometryRegressor(nn.Module):
    """Predicts t.

    Args:
        preset: Its ranking module's size, width and maps are this network's too.

    Attributes:
        size: Side of the maps that it reads, pixels.
    """

    def __init__(self, preset: Preset) -> None:
        super().__init__()
        self.size, outputs = preset.ranking.size, 16 * preset.ranking.width
        self.mesh = MeshEncoder(preset.ranking.width, outputs)
        self.image = ImageEncoder(preset, outputs)
        self.layers = nn.Sequential(
            nn.Linear(2 * outputs, outputs // 2),
            nn.ReLU(),
            nn.Linear(outputs // 2, outputs // 8),
            nn.ReLU(),
            nn.Linear(outputs // 8, THRESHOLDS),
        )

    def forward(self, graph: MeshGraph, maps: Tensor, largest: Tensor) -> Tensor:
        """The thresholds of B views.

        Args:
            graph: Their meshes.
            maps: (B, K, size, size) their maps.
            largest: (B, 4) the largest feature along each family's lines; 0 where there are none.

        Returns:
            (B, 4) t, at least 0 and below `largest`: from there on no line would be left, and no gradient.
        """
        return bounded(self.layers(torch.cat([self.mesh(graph), self.image(maps)], dim=1)), largest)


def bounded(raw: Tensor, largest: Tensor) -> Tensor:
    """Any numbers as thresholds: softplus makes them positive, and s -> G s / (G + s) keeps them below G = `largest`.

    Small ones stay as they are, and the slope (G / (G + s))^2 is positive everywhere.
    """
    positive = functional.softplus(raw.to(largest.dtype))
    return largest * positive / (largest + positive)
