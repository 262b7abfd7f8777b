"""Who imports whom, read from the text of the tree: for the test of its layers and for the drawing of them."""

import ast
from collections.abc import Iterable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CHAIN = ("ncmodel", "dataset_tools", "eval")
"""Each package may import those before it."""
TEMPLATES = "mturk_templates"


def modules_below(root: Path) -> dict[str, Path]:
    """Dotted name -> file of every module of the packages."""
    found = {}
    for package in (*CHAIN, TEMPLATES):
        for path in sorted((root / package).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports_of(modules: Mapping[str, Path]) -> dict[str, set[str]]:
    """Module -> the project's modules that it imports, anywhere in its text."""
    return {module: set(_imported(path, modules)) - {module} for module, path in modules.items()}


def _imported(path: Path, modules: Mapping[str, Path]) -> Iterable[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the layer they reach"
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                if inner in modules or node.module in modules:
                    yield inner if inner in modules else str(node.module)


def package_of(module: str) -> str:
    """The package that a module or folder lies in."""
    return module.partition(".")[0]


def folder_of(module: str, modules: Mapping[str, Path]) -> str:
    """The folder that a module lies in; what lies at a package's top is a layer of its own."""
    return module if modules[module].name == "__init__.py" else module.rpartition(".")[0]


def folder_imports(modules: Mapping[str, Path]) -> dict[str, set[str]]:
    """Folder -> the other folders that its modules import."""
    graph: dict[str, set[str]] = {folder_of(module, modules): set() for module in modules}
    for module, others in imports_of(modules).items():
        graph[folder_of(module, modules)] |= {folder_of(other, modules) for other in others}
    return {folder: others - {folder} for folder, others in graph.items()}
