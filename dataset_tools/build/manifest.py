"""A folder's `manifest.json`: what it was made from, and the sizes and checksums by which damage is found."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ncmodel.parsing import parse_json

MANIFEST = "manifest.json"


def manifest_of(files: Mapping[str, bytes], origin: str) -> dict[str, Any]:
    """The manifest of a folder.

    Args:
        files: Name -> content.
        origin: Checksum of what the files were made from.
    """
    sums = {name: {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()} for name, data in files.items()}
    return {"from": origin, "files": sums}


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """A folder's manifest; None where it is missing or isn't one."""
    manifest = read_json(folder / MANIFEST)
    if manifest is None or not isinstance(manifest.get("from"), str) or not isinstance(manifest.get("files"), dict):
        return None
    entries = manifest["files"].values()
    sound = all(isinstance(entry, dict) and {"bytes", "sha256"} <= set(entry) for entry in entries)
    return manifest if sound and entries else None


def damage(folder: Path, verify: bool = False) -> str:
    """What is wrong with a folder that has a manifest; "" when it is as it was written.

    Args:
        folder: The folder.
        verify: Compare checksums too; otherwise only names and sizes of files.
    """
    while True:
        before = _identity(folder)
        found = _first_damage(folder, verify)
        if not found or _identity(folder) == before:
            return found  # else it was replaced meanwhile


def _first_damage(folder: Path, verify: bool) -> str:
    manifest = read_manifest(folder)
    if manifest is None:
        return f"{MANIFEST} is missing or damaged"
    for name, entry in manifest["files"].items():
        try:
            size = (folder / name).stat().st_size
            if size != entry["bytes"]:
                return f"{name} has {size} bytes, expected {entry['bytes']}"
            if verify and file_checksum(folder / name) != entry["sha256"]:
                return f"{name} was changed"
        except FileNotFoundError:
            return f"{name} is missing"
        except OSError as error:
            return f"{name} can't be read ({error.strerror})"
    return ""


def file_checksum(path: Path) -> str:
    """SHA-256 of a file's content, in hexadecimal."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_json(path: Path) -> dict[str, Any] | None:
    """A JSON object, or None when the file is missing or isn't one."""
    try:
        record = parse_json(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return record if isinstance(record, dict) else None


def _identity(folder: Path) -> tuple[int, int] | None:
    """Tells a folder from another one that took its place."""
    try:
        status = folder.stat()
    except OSError:
        return None
    return status.st_ino, status.st_ctime_ns
