"""Mesh files of a robot: where they may lie, and what is in them. Files .dae and .obj have colours and textures, others have none."""

from __future__ import annotations

import io
import warnings
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

from ...ground.errors import InputError
from .mesh_parts import Mesh, UnreadableMesh
from .mesh_readers import coal_mesh, collada_mesh, stl_mesh, wavefront_mesh

#: Largest mesh file and image file in bytes.
LARGEST_MESH = 50_000_000

#: Endings of files with colours, which have their own readers, and of all.
WITH_COLORS = (".obj", ".dae")
MESH_ENDINGS = (".stl", ".ply", *WITH_COLORS)

#: Formats and endings of images, the most pixels of one, and those along the longer side of one that the page embeds.
_IMAGES = {"PNG": (".png",), "JPEG": (".jpg", ".jpeg"), "BMP": (".bmp",), "TGA": (".tga",), "TIFF": (".tif", ".tiff")}
_MOST_PIXELS, _SIDE = 50_000_000, 512

_RULE = "mesh files lie in the folder of the URDF, in its package, or in package_dirs: name their folder there"


class MissingMesh(InputError):
    """A mesh file that is not there, or not in a folder from which files are read."""


class MeshFiles:
    """The mesh files of a robot; those that were read are kept, since links and collision shapes share them.

    Args:
        folder: of the URDF, None where it was given as a text.
        package_dirs: folders that hold the packages of package://NAME/...
    """

    def __init__(self, folder: Path | None, package_dirs: tuple[Path, ...]):
        self.folder, self.package_dirs = folder, package_dirs
        self._meshes: dict[tuple, Mesh] = {}
        self._with_images: dict[tuple, Mesh] = {}

    def mesh(self, name: str, scale, where: str, *, images: bool = False) -> Mesh:
        """The mesh of a file."""
        path, roots = self._file(name, where)
        mesh = self.read(path, scale, roots, where)
        if not images:
            return mesh
        key = (path, tuple(scale))
        if key not in self._with_images:
            self._with_images[key] = _with_images(mesh, path, roots)
        return self._with_images[key]

    def read(self, path: Path, scale, roots: tuple[Path, ...], where: str) -> Mesh:
        """The mesh of a file by its path."""
        key = (path, tuple(scale))
        if key not in self._meshes:
            self._meshes[key] = read_mesh(path, scale, roots, where)
        return self._meshes[key]

    def path(self, name: str, where: str) -> Path:
        """The path of a mesh: in the folder of the URDF, in its package, or in a package directory.

        package://NAME/... is looked for in the folder NAME of a package directory, and in the folder NAME that the URDF lies in.
        """
        return self._file(name, where)[0]

    def _file(self, name: str, where: str) -> tuple[Path, tuple[Path, ...]]:
        """The path of a mesh, and the folders from which it and what it names may be read."""
        (roots, rest), given = self._roots(name, where), name
        paths = [(root / rest).resolve() for root in roots]
        path = next((path for path in paths if path.is_file()), paths[0])
        if not _lies_in(path, roots):
            raise MissingMesh(f"{where}: the mesh {given[:60]!a} leads out of its folder; {_RULE}")
        if path.suffix.lower() not in MESH_ENDINGS:
            raise MissingMesh(f"{where}: found the mesh {path.name[:60]!a}; expected a file that ends in {', '.join(MESH_ENDINGS)}")
        if not path.is_file():
            raise MissingMesh(f"{where}: there is no mesh file {given[:60]!a}")
        if path.stat().st_size > LARGEST_MESH:
            raise MissingMesh(f"{where}: the mesh {path.name} has {path.stat().st_size:,} bytes; at most {LARGEST_MESH:,} are read")
        return path, roots

    def _roots(self, name: str, where: str) -> tuple[tuple[Path, ...], str]:
        """The folders from which a mesh may be read, and its path in them."""
        given, name = name, unquote(name)
        kind, _, rest = name.partition("://")
        if kind in ("package", "model") and (rest.startswith("/") or "/" not in rest):  # no package: next to the file
            name = rest.lstrip("/")
            kind = ""
        if kind in ("package", "model"):
            package, _, name = rest.partition("/")
            roots = self._packages(package)
            if not roots:
                raise MissingMesh(
                    f'{where}: found the mesh of the {kind} "{package[:60]}", which is in none of package_dirs; {_RULE}'
                )
        elif self.folder is None and not self.package_dirs:
            raise MissingMesh(
                f"{where}: found the mesh {given[:60]!a}, but the URDF was given as a text; give its path, or package_dirs"
            )
        else:
            name = name.removeprefix("file://")
            roots = (*([self.folder] if self.folder else []), *self.package_dirs)
        if "://" in name or "\0" in name or not name:
            raise MissingMesh(f"{where}: found the mesh {given[:60]!a}; {_RULE}")
        return roots, name

    def _packages(self, package: str) -> tuple[Path, ...]:
        """The folders of a package."""
        if package in ("", ".", ".."):
            return ()
        own = self.folder.resolve() if self.folder else None
        above = [place for place in (own, *own.parents) if place.name == package] if own else []
        return (*(directory / package for directory in self.package_dirs if (directory / package).is_dir()), *above)


def read_mesh(path: Path, scale, roots: tuple[Path, ...], where: str) -> Mesh:
    """The mesh of a file; what no other reader can read, coal reads without colours, or names what is wrong."""
    with suppress(UnreadableMesh):
        if path.suffix.lower() == ".dae":
            return collada_mesh(_text(path), scale)
        if path.suffix.lower() == ".obj":
            return wavefront_mesh(_text(path), lambda name: _material_file(path, name, roots), scale)
        if path.suffix.lower() == ".stl":
            return stl_mesh(path.read_bytes(), scale)
    try:
        return coal_mesh(path, scale)
    except UnreadableMesh as problem:
        reason = (str(problem).strip().splitlines() or ["unknown"])[-1][:120]
        raise InputError(f"{where}: the mesh file {path.name} cannot be read ({reason})") from None


def _lies_in(path: Path, roots: tuple[Path, ...]) -> bool:
    return any(path.is_relative_to(root.resolve()) for root in roots)


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def _named_file(mesh: Path, name: str, roots: tuple[Path, ...], endings: tuple[str, ...]) -> Path | None:
    """The file that a mesh file names: by its path or, since exporters write paths of their own machine, by its name alone."""
    name = unquote(name).removeprefix("file://").replace("\\", "/").replace("\0", "")
    for place in (mesh.parent / name, mesh.parent / name.rpartition("/")[2]):
        path = place.resolve()
        if path.suffix.lower() in endings and _lies_in(path, roots) and path.is_file() and path.stat().st_size <= LARGEST_MESH:
            return path
    return None


def _material_file(mesh: Path, name: str, roots: tuple[Path, ...]) -> str:
    path = _named_file(mesh, name, roots, (".mtl",))
    return "" if path is None else _text(path)


def _with_images(mesh: Mesh, path: Path, roots: tuple[Path, ...]) -> Mesh:
    """The mesh with the images that its textures name, and notes on those that are not drawn."""
    parts, notes, images = [], [], {}
    endings = tuple(ending for endings in _IMAGES.values() for ending in endings)
    for part in mesh.parts:
        if part.texture is not None:
            name = str(part.texture.image)
            if name not in images:
                file = _named_file(path, name, roots, endings)
                images[name] = None if file is None else _image(file)
                if images[name] is None:
                    notes.append(f"{name.replace(chr(92), '/').rpartition('/')[2][:60]!a} of {path.name[:60]}")
            image = images[name]
            part = replace(part, texture=None if image is None else replace(part.texture, image=image))
        parts.append(part)
    return replace(mesh, parts=tuple(parts), notes=tuple(notes))


def _image(path: Path) -> bytes | None:
    """The image as a JPEG file of at most 512 pixels along its longer side; None where it cannot be read."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("error")  # an image of very many pixels, or a broken file
        try:
            with Image.open(path, formats=tuple(_IMAGES)) as image:
                if image.width * image.height > _MOST_PIXELS:
                    return None
                image.draft("RGB", (_SIDE, _SIDE))  # a JPEG file is decoded at a size near to it
                small = image.convert("RGB")
            small.thumbnail((_SIDE, _SIDE))
            stream = io.BytesIO()
            small.save(stream, "JPEG", quality=85, optimize=True)
        except Exception:  # decoders raise whatever a broken file leads to
            return None
    return stream.getvalue()
