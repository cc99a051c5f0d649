"""What all elements of a lumped model have in common: a name, words for messages, the bodies that they join."""

from __future__ import annotations

from ..checks import real_number
from ..errors import InputError

#: The body that stays at 0 and has no coordinate.
GROUND = "ground"


class Element:
    """Base of all elements.

    Attributes:
        name: its name, for a body also that of its coordinate.
        end_count: how many different bodies it joins, at least.
    """

    name: str
    end_count = 0

    @property
    def label(self) -> str:
        """The element in a message: its kind and its name."""
        return f'{self.kind} "{self.name}"'

    @property
    def kind(self) -> str:
        """Its kind in words, e.g. torsion spring."""
        letters = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in type(self).__name__)
        return letters.strip()

    @property
    def ends(self) -> dict[str, str | None]:
        """The bodies that it joins, each with the unit that its coordinate must have, None where either will do."""
        return {}

    def _number(self, field: str, **limits) -> None:
        number = real_number(getattr(self, field), f"{self.label}: {field.replace('_', ' ')}", **limits)
        object.__setattr__(self, field, number)  # the way of frozen dataclasses to clean a value

    def _length(self, field: str) -> None:
        self._number(field)
        if getattr(self, field) == 0:
            raise InputError(f"{self.label}: {field.replace('_', ' ')}: found 0; expected a length that is not zero")
