"""The Python of the documentation is run: pages in whole, block after block, and the notebook, cell after cell."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from ncmodel import Camera, draw_shape, load_model
from ncmodel.images import from_ink, read_grey, write_png
from ncmodel.mesh.load import load_mesh
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint, build_network, save_checkpoint
from ncmodel.nets.presets import PRESETS
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.published.rendering import published_view
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from tests.helpers.pages import ROOT, blocks
from tests.helpers.published_weights import NARROW
from tests.helpers.training_data import make_data

NOTEBOOK = ROOT / "examples/first_steps.ipynb"


def run(parts: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Run named pieces of code in one namespace, and return it."""
    namespace: dict[str, Any] = {"__name__": "__main__"}
    for name, text in parts:
        exec(compile(text, name, "exec"), namespace)
    return namespace


def run_page(name: str) -> dict[str, Any]:
    """Run all Python blocks of a page."""
    return run((block.name, block.text) for block in blocks(ROOT / "docs" / name, "python"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    return tmp_path


def write_model(path: Path) -> None:
    """Networks with the weights that training starts from."""
    preset = PRESETS["tiny"]
    ranker, translator = RankingModule(preset.ranking), TranslationBranch(preset.translation)
    for network in (ranker, translator):
        initialise(network, torch.Generator().manual_seed(0))
    save_checkpoint(path, Checkpoint(preset, ranker, translator))


def write_some_votes(path: Path) -> None:
    """Two participants' votes, one of whom failed a sentinel."""
    header = "worker,assignment,questionnaire,question,shape,view,choice,sentinel,passed,seconds,source"
    rows = ["anna,a,q,1,cow,0,3,0,,4.0,site", "anna,a,q,2,cow,0,0,1,1,3.0,site"]
    rows += ["ben,b,q,1,cow,0,3,0,,1.0,site", "ben,b,q,2,cow,0,2,1,0,1.0,site"]
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8")


def test_python_page(folder: Path, bundled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # The cow has a tenth of the bunny's faces.
    (folder / "bunny.obj").write_bytes((bundled / "cow.obj").read_bytes())
    write_png(folder / "yours.png", from_ink(draw_shape("bunny.obj", lines="contours").ink()))
    write_model(folder / "model.safetensors")
    write_some_votes(folder / "votes.csv")
    names = run_page("python.md")
    for name in ("bunny.svg", "bunny.pdf", "bunny.png", "tetrahedron.svg", "back.png", "plot.svg"):
        assert (folder / name).stat().st_size > 500
    assert "found 'wrinkles'" in capsys.readouterr().out
    assert {stroke.family for stroke in names["drawing"].strokes} >= {"contours", "ridges"}
    assert len(names["turntable"]) == 4
    assert names["chosen"].plan.thresholds.unit == "p90"
    assert names["passed"].to_dict() == {"anna": 1.0, "ben": 0.0}
    # Contours alone are part of the drawing that they are compared with.
    assert names["found"].recall > 0.95


def test_training_page(folder: Path) -> None:
    make_data(folder / "data", shapes=3, views=1, held_out=1).rename("pairs.jsonl")
    history = {"ranker": [{"epoch": 1, "loss": 0.9, "hinge": 1.0}, {"epoch": 2, "loss": 0.8, "hinge": 0.9}]}
    (folder / "model.safetensors.history.json").write_text(json.dumps(history), encoding="utf-8")
    names = run_page("training.md")
    assert list(names["curves"].columns) == ["loss", "hinge"]
    assert (folder / "slow.safetensors").exists()
    assert load_model("logistic.safetensors").variants == ("geometry",)
    assert len(names["done"].history) == 2
    assert 0.0 <= names["report"].stages[0].validation["accuracy"] <= 1.0


def cells() -> list[tuple[str, str]]:
    """The code cells of the notebook, with where they stand."""
    found = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    return [
        (f"{NOTEBOOK.name}[{number}]", "".join(cell["source"]))
        for number, cell in enumerate(found)
        if cell["cell_type"] == "code"
    ]


def test_notebook(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_some_votes(folder / "votes.csv")
    names = run(cells())
    assert Camera.load(folder / "cow-side.json") == names["camera"]
    assert read_grey(folder / "cow-side.png").shape == (480, 640)
    assert (folder / "cow-side.svg").read_text(encoding="utf-8").count("<path") > 10
    assert np.isfinite(names["longest"].points).all()
    assert 0.5 < min(names["found"].precision, names["found"].recall) < 1.0
    assert "no votes.csv here" not in capsys.readouterr().out


def test_notebook_is_stored_without_outputs() -> None:
    stored = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    assert len(cells()) >= 8
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in stored if "outputs" in cell)


@pytest.mark.slow
def test_published_page(folder: Path, bundled: Path) -> None:
    networks = {name: build_network(name, NARROW) for name in ("ranker", "translator")}
    for seed, network in enumerate(networks.values()):
        initialise(network, torch.Generator().manual_seed(seed))
    save_checkpoint(folder / "official.safetensors", Checkpoint(NARROW, **networks))  # type: ignore[arg-type]
    mesh = load_mesh(bundled / "cow.obj")
    view = published_view(View(Surface(mesh), Camera.orbit(mesh.vertices, size=(1024, 768))))
    (folder / "bumps_a").mkdir()
    for name, content in view.files().items():
        (folder / "bumps_a" / name).write_bytes(content)
    names = run_page("published.md")
    assert names["paper"].shape == names["ink"].shape == names["choice"].ink.shape == (768, 1024)
    assert np.isfinite([names["value"], *names["slope"]]).all()
    assert names["choice"].plan.thresholds.unit == "published"
