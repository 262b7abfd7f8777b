"""The layout shows the architecture, and imports go one way."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("ncmodel", "dataset_tools", "mturk_templates", "eval")

FORBIDDEN = {
    # A module whose dotted name starts with the key never imports one that starts with a value.
    "ncmodel": ("dataset_tools", "eval", "mturk_templates"),
    "dataset_tools": ("eval", "ncmodel.cli"),
    "eval": ("dataset_tools", "ncmodel.cli"),
    "mturk_templates": ("ncmodel", "dataset_tools", "eval"),
    "ncmodel.geometry": ("ncmodel.nets", "ncmodel.draw", "ncmodel.maps", "ncmodel.train", "ncmodel.model"),
    "ncmodel.nets": ("ncmodel.geometry", "ncmodel.draw", "ncmodel.maps", "ncmodel.train", "ncmodel.model"),
    "ncmodel.types": ("ncmodel.",),
    "ncmodel.errors": ("ncmodel.",),
}
TOP_LAYER = "ncmodel.cli"


def _modules() -> dict[str, Path]:
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def _imports(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the layer they reach"
            assert node.module is not None
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def _reaches(name: str, target: str) -> bool:
    return name == target.rstrip(".") or name.startswith(target.rstrip(".") + ".")


def violations(modules: dict[str, Path]) -> list[str]:
    """Every import that goes the wrong way."""
    wrong = []
    for module, path in modules.items():
        in_top = _reaches(module, TOP_LAYER)
        for layer, targets in FORBIDDEN.items():
            if not _reaches(module, layer) or in_top:
                continue
            wrong += [
                f"{module} imports {name}" for name in _imports(path) for target in targets if _reaches(name, target)
            ]
        if not in_top:
            wrong += [f"{module} imports {name}" for name in _imports(path) if _reaches(name, TOP_LAYER)]
    return wrong


def test_imports_go_one_way() -> None:
    modules = _modules()
    assert len(modules) > 20
    assert violations(modules) == []


def test_the_check_can_fail(tmp_path: Path) -> None:
    bad = tmp_path / "filters.py"
    bad.write_text("from dataset_tools.store import Store\n", encoding="utf-8")
    assert violations({"ncmodel.filters": bad}) == ["ncmodel.filters imports dataset_tools.store.Store"]


def test_no_import_cycles() -> None:
    modules = _modules()
    edges = {
        module: {
            other
            for name in _imports(path)
            for other in (name, name.rpartition(".")[0])
            if other in modules and other != module
        }
        for module, path in modules.items()
    }
    finished: set[str] = set()
    for start in edges:
        _walk(start, edges, (), finished)


def _walk(module: str, edges: dict[str, set[str]], path: tuple[str, ...], finished: set[str]) -> None:
    assert module not in path, f"import cycle: {' -> '.join([*path, module])}"
    if module in finished:
        return
    for other in edges[module]:
        _walk(other, edges, (*path, module), finished)
    finished.add(module)


@pytest.mark.parametrize(
    ("statement", "heavy"),
    [
        ("import ncmodel", ("torch", "numba", "pymeshlab", "matplotlib", "pandas")),
        ("import ncmodel.cli.main", ("torch", "numba", "pymeshlab", "matplotlib", "pandas", "trimesh", "distributed")),
        ("import ncmodel.draw", ("torch", "pymeshlab", "matplotlib", "pandas")),
        ("import ncmodel.geometry.view", ("torch", "pymeshlab", "matplotlib", "pandas")),
    ],
)
def test_heavy_packages_wait_until_they_are_needed(statement: str, heavy: tuple[str, ...]) -> None:
    code = f"import sys; {statement}; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_package_and_template_is_installed() -> None:
    import tomllib

    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    packages = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for name in PACKAGES
        for path in ROOT.glob(f"{name}/**/__init__.py")
    }
    assert set(settings["packages"]) == packages
    data = {path for name in PACKAGES for path in (ROOT / name).rglob("*") if path.suffix in {".j2", ".css", ".js"}}
    listed = {
        path
        for package, patterns in settings["package-data"].items()
        for pattern in patterns
        for path in (ROOT / package.replace(".", "/")).glob(pattern)
    }
    assert data == listed
