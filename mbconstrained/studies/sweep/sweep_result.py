"""Result of a study: arrays by name, scalar quantities with their statistics, samples without an answer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import counted, nearest, optional_package
from ...ground.display import Displayed
from ...ground.errors import InputError, shown
from ...scene.schema.analyses.vary_table import VaryTable
from .evaluation import ANSWERED, Job
from .kept_quantities import SampleFigure, Variable, figures_of, limits_of
from .sample_statistics import Estimate, SobolIndices, Summary, exceedance, sobol_indices, summary
from .sampling import ParameterSamples
from .store import REASON, STATUS, Chunks, column_name

if TYPE_CHECKING:
    from ...scene.run.scene import Scene


ONLY_RANDOM = "limits: probabilities need distributions of all parameters, and some have given values"


@dataclass(frozen=True, repr=False, eq=False)
class SampleAnswers(Displayed):
    """The samples of a study with what was kept of each, without its report.

    Attributes:
        scene: of the study.
        samples: samples of its parameters.
        variables: kept quantities.
        table: [vary].
        job: makes the scene of a sample.
        chunks: storage of the arrays.
    """

    scene: Scene
    samples: ParameterSamples
    variables: tuple[Variable, ...]
    table: VaryTable
    job: Job
    chunks: Chunks

    def _summary(self) -> str:
        failed = len(self.samples) - int(self.answered.sum())
        return f"{self.scene.name}, {counted(len(self.samples), 'sample')}{f', {failed} without an answer' if failed else ''}"

    def __len__(self) -> int:
        return len(self.samples)

    @cached_property
    def answered(self) -> np.ndarray:
        """Whether each sample has an answer, shape (S,)."""
        return self.chunks.read(STATUS) == ANSWERED

    @property
    def failures(self) -> dict[int, str]:
        """Reasons of the samples without an answer, by index from 0."""
        places = np.flatnonzero(~self.answered).tolist()
        reasons = self.chunks.read(REASON) if places else []
        return {place: str(reasons[place]) for place in places}

    def parameter(self, name: str) -> np.ndarray:
        """The values of a varied parameter, numbers in SI or texts, shape (S,)."""
        if name not in self.samples.variations:
            raise InputError(
                f'"{name}" is not varied{nearest(name, self.samples.variations)}; there are {", ".join(self.samples.variations)}'
            )
        return self.samples.column(name)

    def values(self, name: str) -> np.ndarray:
        """Return a kept variable or scalar quantity over the samples, NaN for those without an answer.

        Args:
            name: such as "frequency" or "frequency 1".

        Returns:
            Numbers in SI, shape (S,), of a variable with an axis (S, n).

        Raises:
            InputError: nothing of this name was kept.
        """
        if name in (one.name for one in self.variables):
            return self.chunks.read(name)
        figure = self.figures.get(name)
        if figure is None:
            known = list(dict.fromkeys([*(one.name for one in self.variables), *self.figures]))
            raise InputError(f"{shown(name)} was not kept{nearest(name, known)}; there are {', '.join(known[:20])}")
        return self.chunks.read(figure.variable.name, figure.place)

    @cached_property
    def figures(self) -> dict[str, SampleFigure]:
        """Scalar quantities of each sample, by name."""
        return figures_of(self.variables)

    def statistics(self, name: str) -> Summary:
        """Return moments and quantiles of a scalar quantity."""
        return summary(self.independent(name))

    def independent(self, name: str) -> np.ndarray:
        """Return the values of a scalar quantity in the samples drawn from the distributions."""
        return self.values(name)[: self.samples.independent] if self.samples.is_random else self.values(name)

    @property
    def limits(self) -> dict[str, float]:
        """Limits of scalar quantities in SI."""
        return limits_of(self.table.limits, self.figures)

    def exceedance(self, name: str, limit: float) -> Estimate:
        """Return the probability that a scalar quantity exceeds a limit.

        Args:
            name: name of the figure.
            limit: in SI.

        Returns:
            The estimate with its interval.

        Raises:
            InputError: the samples are no random ones.
        """
        if not self.samples.is_random:
            raise InputError(ONLY_RANDOM)
        return exceedance(self.independent(name), limit)

    def sobol_indices(self, name: str) -> SobolIndices:
        """Return Sobol indices: the shares of the variance of a scalar quantity caused by each parameter.

        Raises:
            InputError: another method than saltelli, a sample without an answer.
        """
        if self.table.method != "saltelli":
            raise InputError('Sobol indices need method = "saltelli"')
        return sobol_indices(self.values(name), self.table.samples)

    def sample_scene(self, number: int) -> Scene:
        """Return the scene of a sample.

        Args:
            number: from 0.

        Returns:
            The scene, ready to be run.
        """
        return self.job.scene(self.samples.rows(slice(number, number + 1))[0])

    def to_xarray(self):
        """Return all variables as an ``xarray.Dataset`` over the samples, with units as attributes.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        variables: dict[str, Any] = {}
        for name, one in self.samples.variations.items():
            variables[column_name(name)] = ("sample", self.samples.column(name), {"units": one.unit} if one.unit else {})
        coordinates: dict[str, Any] = {}
        for variable in self.variables:
            axes = ["sample", *([variable.axis] if variable.axis else [])]
            variables[variable.name] = (axes, self.chunks.read(variable.name), {"units": variable.unit})
            coordinates |= {variable.axis: list(variable.labels)} if variable.axis else {}
        variables |= {name: ("sample", self.chunks.read(name)) for name in (STATUS, REASON)}
        return xarray.Dataset(variables, coordinates, {"source": "mbconstrained"})

    def csv(self) -> str:
        """Return parameters and scalar quantities of each sample as CSV, numbers in SI."""
        from ...exchange.trajectories import csv_of

        units = {name: one.unit for name, one in self.samples.variations.items()}
        columns = {f"{name} ({unit})" if (unit := units[name]) else name: self.samples.column(name) for name in units}
        columns |= {
            f"{one.name} ({one.unit})" if one.unit not in ("", "1") else one.name: self.values(one.name)
            for one in self.figures.values()
        }
        return csv_of({"sample": np.arange(len(self)), **columns, REASON: self.chunks.read(REASON)})
