"""Items: the views of shapes whose drawings participants compare and the model learns to rank."""

from dataclasses import dataclass

DRAWINGS = 8
"""Drawings of an item, which participants choose among."""


@dataclass(frozen=True, order=True)
class Item:
    """One view of one shape, with its 8 candidate drawings."""

    shape: str
    view: str

    @staticmethod
    def named(name: str) -> "Item":
        """The item of a name SHAPE_VIEW, of which the shape's part may hold underscores too.

        Raises:
            ValueError: It isn't such a name.
        """
        shape, _, view = name.rpartition("_")
        if not shape or not view:
            raise ValueError(f"{name!r} isn't SHAPE_VIEW")
        return Item(shape, view)

    @property
    def name(self) -> str:
        """The name of its folder: SHAPE_VIEW."""
        return f"{self.shape}_{self.view}"

    @property
    def record(self) -> dict[str, str | int]:
        """Its shape and view as JSON files hold them: a view's number is a number there."""
        number = self.view.isdecimal() and str(int(self.view)) == self.view
        return {"shape": self.shape, "view": int(self.view) if number else self.view}
