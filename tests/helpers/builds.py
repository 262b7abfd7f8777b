"""A small data folder, built in moments, and what is in it."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from dataset_tools.build.build import Summary, build_dataset, folder_status
from dataset_tools.build.config import BuildConfig
from dataset_tools.build.mesh_files import find_sources
from dataset_tools.build.runners import HereRunner, Runner
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers import dirty

CONFIG = BuildConfig(width=64, height=48, render_size=32, min_faces=100)


def make_meshes(folder: Path) -> Path:
    """Two shapes that can be drawn, one of them inside out, one that can't, and one of low resolution."""
    folder.mkdir()
    egg = dirty.sphere(fineness=2)
    bumpy = (egg[0] * (1 + 0.2 * np.sin(5 * egg[0][:, :1])), egg[1])
    parts = {
        "ball": dirty.sphere(fineness=2),
        "odd/bumpy": dirty.inside_out(bumpy),
        "cube": dirty.box(),
        "soup": (np.random.default_rng(0).random((900, 3)), np.arange(900).reshape(-1, 3)),
    }
    for name, part in parts.items():
        path = folder / f"{name}.ply"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(ply_bytes(Mesh(*part)))
    return folder


def build(meshes: Path, folder: Path, runner: Runner | None = None, retry: bool = False) -> Summary:
    """Build with this module's settings, in this process unless another runner is given."""
    return build_dataset(find_sources(meshes, folder), folder, CONFIG, runner or HereRunner(), retry=retry)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file but those that hold times and process numbers."""
    files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    return {name: data for name, data in files.items() if name not in (".lock", "index.csv")}


def state(folder: Path) -> dict[tuple[str, int], str]:
    """(shape, view) -> status."""
    return {(row.shape, row.view): row.status for row in folder_status(folder)}


def start_build(meshes: Path, folder: Path) -> "subprocess.Popen[bytes]":
    """Start the build in a process group of its own, with the settings of the reference beside the meshes."""
    (meshes.parent / "settings.toml").write_text((meshes.parent / "reference" / "config.toml").read_text())
    command = [sys.executable, "-m", "ncmodel.cli.main", "dataset", "build", str(meshes), str(folder), "--workers", "2"]
    command += ["--config", str(meshes.parent / "settings.toml")]
    return subprocess.Popen(
        command,
        cwd=Path(__file__).parents[2],
        start_new_session=True,
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
