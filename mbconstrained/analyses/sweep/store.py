"""Storage of chunks of samples: memory, or a Zarr store that survives interruptions.

A store is a Zarr group that ``xarray.open_zarr`` reads, with one array for each parameter and variable, in chunks of samples. Each
file of a chunk is replaced atomically, followed by the checksum of the chunk for this study and position, and last by its status. A
chunk without a status counts as missing, one with another checksum as damaged; both are computed again. Equal studies give equal
bytes. The store has the hash of scene, data files, samples, kept variables and versions, and is refused
for any other study.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

import numpy as np

from ...ground.checks import counted, optional_package
from ...ground.errors import InputError
from ...ground.files import Replacements
from .kept_quantities import Variable
from .samples import ParameterSamples

#: Variables that every sample has.
STATUS, REASON = "status", "reason"

#: The array of checksums, one of each chunk, and the number of this form of store.
CHECKSUM, FORM = "checksum", 2

#: What zarr raises on damaged files: an array is missing, a codec cannot decode, lengths do not fit. Files that cannot be read are OSErrors.
DAMAGE = (KeyError, RuntimeError, ValueError)

#: Numbers of a study without a store, in bytes.
MOST_MEMORY = 4e9

#: Share of the size of numbers that remains after the best compression.
LEAST_SIZE = 0.5

_KEY = "mbconstrained"


class Chunks(ABC):
    """The arrays of a study by chunks.

    Attributes:
        samples: the parameters.
        variables: kept quantities.
        size: samples of a chunk.
        damaged: numbers of stored chunks that were not as they had been written.
    """

    def __init__(self, samples: ParameterSamples, variables: tuple[Variable, ...], size: int):
        self.samples, self.variables, self.size = samples, variables, size
        self.damaged: list[int] = []

    @property
    def count(self) -> int:
        return -(-len(self.samples) // self.size)

    def at(self, chunk: int) -> slice:
        return slice(chunk * self.size, min((chunk + 1) * self.size, len(self.samples)))

    @property
    def bytes_per_sample(self) -> int:
        """Bytes per sample of the kept numbers, parameters and status."""
        return 8 * (len(self.samples.variations) + sum(int(np.prod(one.shape)) for one in self.variables)) + 1

    @abstractmethod
    def missing(self) -> Iterator[int]:
        """The chunks still to be computed, ascending."""

    @abstractmethod
    def write(self, chunk: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Store a chunk."""

    @abstractmethod
    def read(self, name: str, where: tuple = ()) -> np.ndarray:
        """A variable, its status or reason, for all samples."""


class Memory(Chunks):
    """Arrays in memory."""

    def __init__(self, samples: ParameterSamples, variables: tuple[Variable, ...], size: int):
        super().__init__(samples, variables, size)
        if (needed := self.bytes_per_sample * len(samples)) > MOST_MEMORY:
            raise InputError(f"{counted(len(samples), 'sample')} need {needed / 1e9:.3g} GB of memory; give a store, or keep less")
        self._parts: dict[int, Mapping[str, np.ndarray]] = {}

    def missing(self) -> Iterator[int]:
        return (chunk for chunk in range(self.count) if chunk not in self._parts)

    def write(self, chunk: int, arrays: Mapping[str, np.ndarray]) -> None:
        self._parts[chunk] = {**arrays, REASON: arrays[REASON].astype(str)}  # of no greater width than those of the chunk need

    def read(self, name: str, where: tuple = ()) -> np.ndarray:
        whole = np.concatenate([self._parts[chunk][name] for chunk in sorted(self._parts)])
        return whole[(slice(None), *where)]


class Store(Chunks):
    """A Zarr store.

    Args:
        path: path of the folder, which is created, or holds what there is of this study.
        description: description of the study, plain data by subject.
        samples, variables, size: as in ``Chunks``.

    Raises:
        InputError: another folder, a store of another study.
        OSError: it cannot be written.
    """

    def __init__(self, path: Path, description: dict, samples: ParameterSamples, variables: tuple[Variable, ...], size: int):
        super().__init__(samples, variables, size)
        self.path, self.description = path, {**json.loads(json.dumps(description)), "form of the store": FORM}
        self._verified: set[int] = set()
        self._zarr = optional_package("zarr", "a store of samples")
        optional_package("xarray", "a store of samples")
        if path.exists() and not (path.is_dir() and not any(path.iterdir())):
            self._check()
            for left in path.rglob("*.partial"):  # files of a process that was killed
                left.unlink(missing_ok=True)
        else:
            self._check_space(len(samples))
            self._create()
        self._group = self._zarr.open_group(str(path), mode="r+", zarr_format=2, use_consolidated=False)

        for one in variables:
            if one.axis and not self._has_labels(one):
                raise InputError(
                    f"{path}: the store is damaged: {one.axis} is not as it was written; give another path, or remove it"
                )

    def _has_labels(self, variable: Variable) -> bool:
        try:
            return np.asarray(self._group[variable.axis][:]).tolist() == np.array(variable.labels).tolist()
        except DAMAGE:
            return False

    def missing(self) -> Iterator[int]:
        """The chunks without a status, and damaged ones."""
        for chunk in range(self.count):
            status = self.path / STATUS / str(chunk)
            if status.exists() and chunk not in self._verified:
                if self._is_intact(chunk):
                    self._verified.add(chunk)
                else:
                    self.damaged.append(chunk)
                    status.unlink(missing_ok=True)
            if not status.exists():
                yield chunk

    def _is_intact(self, chunk: int) -> bool:
        """Whether the files of a chunk are those written at this position of this study."""
        try:
            status = np.asarray(self._group[STATUS][self.at(chunk)])
            return str(self._group[CHECKSUM][chunk]) == self._checksum(chunk, status)
        except DAMAGE:
            return False

    def _checksum(self, chunk: int, status: np.ndarray) -> str:
        """SHA-256 of the study, the position, and the files of a chunk; for the status, which is written last, its values."""
        digest = sha256(f"{hash_of(self.description)} {chunk}".encode())
        for name in sorted({*map(column_name, self.samples.variations), *(one.name for one in self.variables), REASON}):
            for file in sorted([self.path / name / str(chunk), *(self.path / name).glob(f"{chunk}.*")]):
                if file.is_file() and file.suffix != ".partial":
                    digest.update(f"{name}/{file.name} ".encode() + sha256(file.read_bytes()).digest())
        return digest.hexdigest() + sha256(np.asarray(status, dtype=np.uint8).tobytes()).hexdigest()[:16]

    def write(self, chunk: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Write the files of a chunk, its status last."""
        at = self.at(chunk)
        parts = {column_name(name): self.samples.column(name, at) for name in self.samples.variations}
        order = [name for name in arrays if name != STATUS]
        try:
            for name, values in [*parts.items(), *((name, arrays[name]) for name in order)]:
                self._group[name][at] = values
            self._group[CHECKSUM][chunk] = self._checksum(chunk, arrays[STATUS])
            self._group[STATUS][at] = arrays[STATUS]
            self._verified.add(chunk)
        except OSError as problem:
            done = self.count - sum(1 for _ in self.missing())
            text = (
                f"{problem.strerror or problem}; {done} of {self.count} chunks are stored, and the same command goes on from there"
            )
            raise OSError(problem.errno, text, str(self.path)) from None

    def read(self, name: str, where: tuple = ()) -> np.ndarray:
        return np.asarray(self._group[name][(slice(None), *where)])

    def _check_space(self, count: int) -> None:
        """Refuse a study that does not fit, before hours of computation."""
        folder = next(folder for folder in self.path.absolute().parents if folder.exists())
        needed, free = LEAST_SIZE * self.bytes_per_sample * count, shutil.disk_usage(folder).free
        if needed > free:
            text = f"the disk has {free / 1e6:.3g} MB free, and {count:,} samples need at least {needed / 1e6:.3g} MB; take fewer or keep less"
            raise OSError(errno.ENOSPC, text, str(self.path))

    def _create(self) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        for left in self.path.parent.glob(f".{self.path.name}.*"):  # of a process that was killed at this place
            if left.suffix[1:].isdecimal() and not _runs(int(left.suffix[1:])):
                shutil.rmtree(left, ignore_errors=True)
        with Replacements() as files:
            place = files.temporary(self.path)
            shutil.rmtree(place, ignore_errors=True)
            group = self._zarr.open_group(str(place), mode="w", zarr_format=2)
            group.attrs.update({_KEY: self.description, "hash": hash_of(self.description)})
            for name in self.samples.variations:
                values = self.samples.column(name, slice(0, 1))
                kind = self._text_type(name) if values.dtype.kind == "U" else float
                self._array(group, column_name(name), kind, unit=getattr(self.samples.variations[name], "unit", ""))
            for one in self.variables:
                self._array(group, one.name, float, one.axis, len(one.labels), one.unit)
                if one.axis and one.axis not in group:
                    labels = np.array(one.labels)
                    attributes = {"_ARRAY_DIMENSIONS": [one.axis]}
                    options = {"fill_value": None, "compressors": _compressor(), "attributes": attributes}
                    group.create_array(one.axis, data=labels, chunks=labels.shape, **options)
            self._array(group, REASON, "<U160")
            self._array(group, STATUS, np.uint8)
            group.create_array(
                CHECKSUM,
                shape=(self.count,),
                chunks=(1,),
                dtype="<U80",
                fill_value="",
                compressors=_compressor(),
                attributes={"_ARRAY_DIMENSIONS": ["chunk"]},
            )
            self._zarr.consolidate_metadata(group.store)
            if self.path.is_dir():
                self.path.rmdir()  # empty

    def _text_type(self, name: str) -> str:
        return f"<U{max(map(len, self.samples.grid[name].values))}"

    def _array(self, group, name: str, kind, axis: str = "", length: int = 0, unit: str = "") -> None:
        shape, dimensions = (len(self.samples), *([length] if axis else [])), ["sample", *([axis] if axis else [])]
        attributes = {"_ARRAY_DIMENSIONS": dimensions, **({"units": unit} if unit else {})}
        if name == STATUS:
            attributes["meaning"] = "1 answered, 2 without answer, which has its reason, 3 timed out"
        fill = float("nan") if kind is float else None if kind is np.uint8 else ""  # xarray takes what equals the fill for missing
        chunks = (self.size, *([length] if axis else []))
        group.create_array(
            name, shape=shape, chunks=chunks, dtype=kind, fill_value=fill, compressors=_compressor(), attributes=attributes
        )

    def _check(self) -> None:
        """Check that the store belongs to this study."""
        try:
            known = json.loads((self.path / ".zattrs").read_text(encoding="utf-8"))[_KEY]
        except (OSError, ValueError, KeyError, TypeError):
            raise InputError(f"{self.path}: it exists, and is no store of a sweep; give another path") from None
        if difference := first_difference(known, self.description):
            raise InputError(f"{self.path}: the store is of another study: {difference}; give another path, or remove it")
        try:
            whole = json.loads((self.path / ".zmetadata").read_text(encoding="utf-8"))["metadata"]
            changed = [name for name, own in whole.items() if json.loads((self.path / name).read_text(encoding="utf-8")) != own]
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            changed = [".zmetadata"]
        if changed:
            raise InputError(
                f"{self.path}: the store is damaged: {changed[0]} is not as it was written; give another path, or remove it"
            )


def _runs(process: int) -> bool:
    """Whether a process with this number exists."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # of another user
        return True
    return True


def column_name(parameter: str) -> str:
    """The name of the array of a parameter, different from all axes and other arrays."""
    axes = ("chunk", "sample", "mode", "response", "output", "time (s)", "frequency (Hz)")
    reserved = (STATUS, REASON, CHECKSUM, *axes, "frequency", "damping ratio")
    return f"parameter {parameter}" if parameter in reserved else parameter


def _compressor():
    """A compressor whose bytes depend on the content alone; those of Blosc depend on threads."""
    from numcodecs import Zstd

    return Zstd(level=3)


def hash_of(description: dict) -> str:
    """The hash of plain data.

    >>> hash_of({"a": 1})[:8]
    '015abd7f'
    """
    return sha256(json.dumps(description, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def first_difference(known, here, place: str = "") -> str:
    """The first difference of two plain descriptions, as text; empty where they are equal.

    >>> first_difference({"scene": {"k": "1 N/m"}}, {"scene": {"k": "2 N/m"}})
    'scene.k is "1 N/m" in the store and "2 N/m" here'
    """
    if isinstance(known, dict) and isinstance(here, dict):
        pairs = [(key, known.get(key), here.get(key)) for key in sorted({*known, *here})]
        return next((text for key, a, b in pairs if (text := first_difference(a, b, f"{place}.{key}".removeprefix(".")))), "")
    if isinstance(known, list) and isinstance(here, list) and len(known) == len(here):
        pairs = [(f"{place}[{number}]", a, b) for number, (a, b) in enumerate(zip(known, here), 1)]
        return next((text for where, a, b in pairs if (text := first_difference(a, b, where))), "")
    if known == here:
        return ""
    texts = ["missing" if one is None else _short(one) for one in (known, here)]
    return f"{place} is {texts[0]} in the store and {texts[1]} here"


def _short(value) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:60]}…"


def files_of(tables, folder: Path) -> dict[str, str]:
    """The data files named in tables, and those in folders of robots, with the hashes of their contents."""
    result: dict[str, str] = {}
    for text in _texts(tables):
        path = folder / text if text and text.isprintable() and len(text) < 256 else None
        if path is None or text in (".", ".."):
            continue
        try:
            files = [path] if path.is_file() else sorted((*path.glob("*.toml"), *path.glob("*.urdf"))) if path.is_dir() else []
            result |= {os.path.relpath(file, folder).replace(os.sep, "/"): sha256(file.read_bytes()).hexdigest() for file in files}
        except (OSError, ValueError):
            result[text] = "unreadable"
    return dict(sorted(result.items()))


def _texts(value) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for entry in value.values() if isinstance(value, dict) else value if isinstance(value, (list, tuple)) else ():
        yield from _texts(entry)


def variable_data(variables: tuple[Variable, ...]) -> list[dict]:
    return [{key: value for key, value in asdict(one).items() if key != "units" or value} for one in variables]
