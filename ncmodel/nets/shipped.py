"""The model that ships with the package, and where it lies. `default.md` beside it is its card."""

from pathlib import Path

DEFAULT = "default"
"""The name by which commands and `load_model` know it."""

DEFAULT_PATH = Path(__file__).with_name("default.safetensors")


def checkpoint_path(name: str | Path) -> Path:
    """The file that is meant: the model that ships for `DEFAULT` (unless a file of that name is there), else itself."""
    path = Path(name)
    return DEFAULT_PATH if str(name) == DEFAULT and not path.exists() else path
