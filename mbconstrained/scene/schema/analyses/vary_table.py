"""The table [vary]: varied parameters of a scene, their sampling, and the quantities kept of each sample."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from ....ground.errors import InputError
from ...file.messages import named, shown
from ...quantities.variations import FORMS, Variation, variation_of
from ..entry_types import Table, Text

Method = Literal["random", "latin hypercube", "sobol", "saltelli", "one at a time"]


def _variations(value) -> dict[str, Variation]:
    if not isinstance(value, dict):
        raise InputError(f"found {shown(value)}; expected names with ranges, lists or distributions: {FORMS}")
    result = {}
    for name, given in value.items():
        with named(name):
            result[name] = variation_of(given)
    return result


def _parts(entry):
    """The entry, or the names and the number of a text such as "k,m=0.5"."""
    if not isinstance(entry, str):
        return entry
    names, _, value = entry.partition("=")
    try:
        return [*(name.strip() for name in names.split(",")), float(value)]
    except ValueError:
        raise InputError(f'found "{entry}"; expected A,B=R, e.g. k,m=0.5') from None


def _correlations(value) -> list[tuple[str, str, float]]:
    entries = [_parts(entry) for entry in (value if isinstance(value, list) else [value])]
    for entry in entries:
        is_entry = isinstance(entry, (list, tuple)) and len(entry) == 3
        if not (is_entry and all(isinstance(name, str) for name in entry[:2]) and isinstance(entry[2], (int, float))):
            raise InputError(f'found {shown(entry)}; expected two parameters and their correlation, e.g. ["k", "m", 0.5]')
    return [(one, other, float(rho)) for one, other, rho in entries]


class VaryTable(Table):
    """Parameters that are varied: by the commands sweep and optimise."""

    MOST_SAMPLES: ClassVar[int] = 100_000_000

    parameters: Annotated[
        dict[str, Any],
        BeforeValidator(_variations),
        WithJsonSchema({"type": "object", "additionalProperties": {"anyOf": [{"type": "string"}, {"type": "array"}]}}),
    ] = Field({}, description=f"By the name of a parameter or by place, as for --set: {FORMS}.")
    method: Method = Field(
        "random",
        description="Sampling of the distributions; saltelli: for Sobol indices; one at a time: low and high values for a tornado plot.",
    )
    samples: int = Field(1000, ge=1, le=MOST_SAMPLES, description="Number of samples, at each combination of given values.")
    seed: int = Field(0, ge=0, le=2**63 - 1, description="Seed of the random numbers.")
    correlation: Annotated[
        list[Any], BeforeValidator(_correlations), WithJsonSchema({"type": "array", "items": {"type": "array"}})
    ] = Field([], description='Of the normal scores of two parameters, e.g. [["k", "m", 0.5]].')
    keep: list[Text] | None = Field(
        None,
        description='Kept quantities of each sample: "frequencies", "response peaks", "random RMS", "maximum x", "x at 2 s", "curve x" …; '
        "left out: frequencies, response peaks and RMS values, and the largest values of the plotted coordinates.",
    )
    limits: dict[Text, Any] = Field(
        {}, description='Whose exceedance has its probability estimated, e.g. { "largest x" = "5 mm" }.'
    )
    minimise: Text | None = Field(None, description='The figure that the command optimise makes least, e.g. "response peak".')
    maximise: Text | None = Field(None, description="Or the one that it makes largest.")
    chunk: int | None = Field(None, ge=1, le=100_000, description="Samples that are computed and stored together.")

    @model_validator(mode="after")
    def _known_names(self):
        for one, other, rho in self.correlation:
            if not abs(rho) < 1:
                raise InputError(f"correlation: found {rho:g} of {one} and {other}; expected a number between -1 and 1")
            if one == other:
                raise InputError(f'correlation: found "{one}" twice; expected two parameters')
        return self
