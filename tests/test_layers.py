"""The layout shows the architecture, and imports go one way: between packages, between folders, between modules."""

import subprocess
import sys
import tomllib
from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.helpers.imports import (
    CHAIN,
    ROOT,
    TEMPLATES,
    folder_imports,
    folder_of,
    imports_of,
    modules_below,
    package_of,
)

FEWEST, MOST = 3, 14
"""Modules in a folder."""


def upward(imports: Mapping[str, set[str]]) -> list[str]:
    """Every import against the chain of packages."""
    rank = {TEMPLATES: -1, **{package: n for n, package in enumerate(CHAIN)}}
    return [
        f"{module} imports {other}"
        for module, others in imports.items()
        for other in sorted(others)
        if rank[package_of(module)] < rank[package_of(other)]
    ]


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    """A circle of imports, or nothing."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_packages_form_a_chain() -> None:
    modules = modules_below(ROOT)
    assert len(modules) > 100
    assert upward(imports_of(modules)) == []


def test_folders_import_one_way() -> None:
    assert circle(folder_imports(modules_below(ROOT))) == []


def test_modules_import_one_way() -> None:
    assert circle(imports_of(modules_below(ROOT))) == []


def test_folders_are_ideas_of_a_few_modules() -> None:
    modules = modules_below(ROOT)
    sizes: dict[str, int] = {}
    for module, path in modules.items():
        if path.name != "__init__.py":
            sizes[folder_of(module, modules)] = sizes.get(folder_of(module, modules), 0) + 1
    assert {folder: size for folder, size in sizes.items() if not FEWEST <= size <= MOST} == {}


def _plant(root: Path, files: Mapping[str, str]) -> dict[str, Path]:
    """A small project of these files, each folder a package."""
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        for folder in path.parents:
            if folder == root:
                break
            (folder / "__init__.py").touch()
    return modules_below(root)


def test_an_upward_import_is_found(tmp_path: Path) -> None:
    store = {"dataset_tools/build/store.py": "class Store: ...\n"}
    hidden = "def draw():\n    from dataset_tools.build.store import Store\n"
    for text in ("from dataset_tools.build.store import Store\n", "import dataset_tools.build.store\n", hidden):
        planted = _plant(tmp_path, {**store, "ncmodel/cli/draw.py": text})
        assert upward(imports_of(planted)) == ["ncmodel.cli.draw imports dataset_tools.build.store"]
    planted = _plant(tmp_path, {**store, "ncmodel/cli/draw.py": "from dataset_tools.build import store\n"})
    assert upward(imports_of(planted)) == ["ncmodel.cli.draw imports dataset_tools.build.store"]


def test_a_circle_of_folders_is_found(tmp_path: Path) -> None:
    planted = _plant(
        tmp_path,
        {
            "ncmodel/mesh/load.py": "from ncmodel.drawing.strokes import weld\n",
            "ncmodel/mesh/weld.py": "",
            "ncmodel/drawing/strokes.py": "from ncmodel.mesh import weld\n",
        },
    )
    assert circle(imports_of(planted)) == []
    assert set(circle(folder_imports(planted))) == {"ncmodel.mesh", "ncmodel.drawing"}


@pytest.mark.parametrize(
    ("statement", "heavy"),
    [
        ("import ncmodel", ("torch", "numba", "pymeshlab", "matplotlib", "pandas")),
        ("import ncmodel.cli.main", ("torch", "numba", "pymeshlab", "matplotlib", "pandas", "trimesh", "distributed")),
        ("import ncmodel.drawing.draw", ("torch", "pymeshlab", "matplotlib", "pandas")),
        ("import ncmodel.scene.view", ("torch", "pymeshlab", "matplotlib", "pandas")),
    ],
)
def test_heavy_packages_wait_until_they_are_needed(statement: str, heavy: tuple[str, ...]) -> None:
    code = f"import sys; {statement}; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_needs_no_numbers() -> None:
    code = "import sys; from ncmodel.cli.main import main; main(['--help']); sys.exit('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "evaluate" in done.stdout


def test_every_package_and_template_is_installed() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    assert set(settings["packages"]["find"]["include"]) == {f"{name}*" for name in (*CHAIN, TEMPLATES)}
    modules = modules_below(ROOT)
    assert {path.parent for path in modules.values()} == {
        path.parent for path in modules.values() if path.name == "__init__.py"
    }
    named = (*CHAIN, TEMPLATES)
    kinds = {".j2", ".css", ".js", ".typed", ".pyi", ".safetensors", ".md"}
    data = {path for name in named for path in (ROOT / name).rglob("*") if path.suffix in kinds}
    assert data >= {ROOT / name / "py.typed" for name in named}, "type checkers are told that packages are typed"
    listed = {
        path
        for package, patterns in settings["package-data"].items()
        for pattern in patterns
        for path in (ROOT / package.replace(".", "/")).glob(pattern)
    }
    assert data == listed
