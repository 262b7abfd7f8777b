"""Tests lie where what they test lies, in files that one reads at a sitting, and say nothing twice."""

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.helpers.imports import CHAIN, ROOT

LONGEST = 350
"""Lines of a file."""


def files_below(root: Path) -> list[Path]:
    """All modules of the tests."""
    return sorted((root / "tests").rglob("*.py"))


def too_long(root: Path) -> list[str]:
    """Files that are better split."""
    sizes = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in files_below(root)}
    return [f"{path.relative_to(root)}: {size} lines" for path, size in sizes.items() if size > LONGEST]


def astray(root: Path) -> list[str]:
    """Folders of tests without a folder of the package that they would test."""
    folders = {path.parent.relative_to(root / "tests") for path in files_below(root)}
    return sorted(str(folder) for folder in folders if folder.parts[:1] and _lost(root, folder))


def _lost(root: Path, folder: Path) -> bool:
    return folder.parts[0] in CHAIN and not (root / folder / "__init__.py").is_file()


def said_twice(root: Path) -> list[str]:
    """Functions and classes that stand in several files: the same arguments and the same statements."""
    places: dict[str, list[str]] = {}
    for path in files_below(root):
        for name, content in _definitions(path):
            places.setdefault(content, []).append(f"{path.relative_to(root)}: {name}")
    return [", ".join(found) for found in places.values() if len(found) > 1]


def _definitions(path: Path) -> Iterator[tuple[str, str]]:
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            body = node.body[1:] if ast.get_docstring(node) is not None else node.body
            arguments = ast.dump(node.args) if isinstance(node, ast.FunctionDef) else ""
            yield node.name, "\n".join([arguments, *map(ast.dump, body)])


def borrowed(root: Path) -> list[str]:
    """Imports of one file of tests from another: what both use is a helper or a fixture."""
    return [
        f"{path.relative_to(root)} imports {node.module}"
        for path in files_below(root)
        if path.parent != root / "tests"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("tests.")
        if not str(node.module).startswith("tests.helpers")
    ]


def test_files_are_short() -> None:
    assert len(files_below(ROOT)) > 100
    assert too_long(ROOT) == []


def test_folders_mirror_the_packages() -> None:
    assert astray(ROOT) == []


def test_nothing_is_said_twice() -> None:
    assert said_twice(ROOT) == []


def test_files_of_tests_share_through_helpers_alone() -> None:
    assert borrowed(ROOT) == []


def test_a_long_file_a_strange_folder_and_a_copy_are_found(tmp_path: Path) -> None:
    twice = 'def near(a: int) -> int:\n    """Near."""\n    return a + 1\n'
    planted = {
        "ncmodel/mesh/__init__.py": "",
        "tests/ncmodel/mesh/test_load.py": twice,
        "tests/ncmodel/meshes/test_load.py": "from tests.ncmodel.mesh.test_load import near\n" + "x = 1\n" * LONGEST,
        "tests/helpers/segments.py": twice.replace("near", "close").replace('"""Near."""', '"""Close."""'),
    }
    for name, text in planted.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert too_long(tmp_path) == ["tests/ncmodel/meshes/test_load.py: 351 lines"]
    assert astray(tmp_path) == ["ncmodel/meshes"]
    assert said_twice(tmp_path) == ["tests/helpers/segments.py: close, tests/ncmodel/mesh/test_load.py: near"]
    assert borrowed(tmp_path) == ["tests/ncmodel/meshes/test_load.py imports tests.ncmodel.mesh.test_load"]
