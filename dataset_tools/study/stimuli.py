"""The pictures of the perceptual study: our drawings of its cases, other methods', and renders of the shapes."""

import filecmp
import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ncmodel.errors import InputError, UsageError


@dataclass(frozen=True, order=True)
class Comparison:
    """Our drawing of a case against a rival's."""

    case: str
    rival: str


@dataclass(frozen=True)
class StudyFolders:
    """Where the study's pictures are.

    Attributes:
        ours: Folder with our drawings, CASE.png.
        rivals: Rival's name -> folder with its drawings of the same cases.
        renders: Folder with renders of the shapes, CASE/*.png, the same number for each case.
    """

    ours: Path
    rivals: Mapping[str, Path]
    renders: Path

    @staticmethod
    def from_record(record: Mapping[str, Any]) -> "StudyFolders":
        """The folders as a key holds them."""
        rivals = {str(name): Path(folder) for name, folder in record["rivals"].items()}
        return StudyFolders(Path(record["ours"]), rivals, Path(record["renders"]))

    def record(self) -> dict[str, Any]:
        """What a key holds."""
        rivals = {name: str(folder) for name, folder in self.rivals.items()}
        return {"ours": str(self.ours), "rivals": rivals, "renders": str(self.renders)}

    def under(self, base: Path) -> "StudyFolders":
        """The folders that are told relative to `base`, as paths that can be opened."""
        rivals = {name: base / folder for name, folder in self.rivals.items()}
        return StudyFolders(base / self.ours, rivals, base / self.renders)

    def seen_from(self, base: Path) -> "StudyFolders":
        """The folders told relative to `base`."""

        def relative(folder: Path) -> Path:
            return Path(os.path.relpath(folder.resolve(), base.resolve()))

        rivals = {name: relative(folder) for name, folder in self.rivals.items()}
        return StudyFolders(relative(self.ours), rivals, relative(self.renders))

    def comparisons(self) -> list[Comparison]:
        """Every case with every rival, sorted.

        Raises:
            UsageError: There are no rivals.
            InputError: There are no cases, or a picture is missing.
        """
        if not self.rivals:
            raise UsageError("no rivals: there is nothing to compare with")
        return [Comparison(case, rival) for case in self.cases() for rival in sorted(self.rivals)]

    def are_same(self, comparison: Comparison) -> bool:
        """Whether our drawing and the rival's are the same picture."""
        ours, rival = self.drawing(comparison.case, None), self.drawing(comparison.case, comparison.rival)
        return filecmp.cmp(ours, rival, shallow=False)

    def fingerprint(self, needs: Mapping[Comparison, int]) -> bytes:
        """What the opaque names are keyed with: the drawings, and what is asked about them."""
        digest = hashlib.blake2b()
        for comparison, answers in sorted(needs.items()):
            digest.update(f"{comparison.case} {comparison.rival} {answers}".encode())
            for rival in (None, comparison.rival):
                digest.update(self.drawing(comparison.case, rival).read_bytes())
        return digest.digest()

    def cases(self) -> list[str]:
        """The cases: what we have drawings of.

        Raises:
            InputError: There are none, or a rival's drawing or the renders of one are missing.
        """
        names = sorted(path.stem for path in self.ours.glob("*.png"))
        if not names:
            raise InputError(self.ours, "no drawings", "CASE.png for each case")
        for name in names:
            for folder in self.rivals.values():
                if not (folder / f"{name}.png").is_file():
                    raise InputError(folder / f"{name}.png", "no such file", f"a drawing, as {self.ours} has one")
        counts = {name: len(self.render_paths(name)) for name in names}
        few = min(counts, key=lambda name: counts[name])
        if counts[few] == 0 or counts[few] != max(counts.values()):
            found = f"{counts[few]} renders"
            raise InputError(self.renders / few, found, f"as many as others have ({max(counts.values())}), 1 or more")
        return names

    def render_paths(self, case: str) -> list[Path]:
        """The renders of a case, in order."""
        return sorted((self.renders / case).glob("*.png"), key=lambda path: (len(path.stem), path.stem))

    def drawing(self, case: str, rival: str | None) -> Path:
        """A drawing of a case: the rival's, or ours."""
        return (self.ours if rival is None else self.rivals[rival]) / f"{case}.png"
