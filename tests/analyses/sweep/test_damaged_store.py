"""A store whose files are damaged, missing, or of another place: damage is named, the chunk is computed again, and no number is believed."""

import shutil

import pytest

import mbconstrained as mb
from tests.analyses.sweep.interrupted import SCENE, bytes_of, scene_file


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study of four chunks, its folder, and its values."""
    folder = tmp_path_factory.mktemp("store")
    scene = mb.read_scene(scene_file(folder, SCENE))
    sweep = scene.sweep({"k": mb.linspace("90 N/m", "110 N/m", 8)}, keep=["frequencies"], chunk=2)
    result = sweep.run(store=folder / "k.zarr")
    return sweep, folder / "k.zarr", result.to_xarray().load()


def damages():
    def flipped(place):
        def damage(path):
            data = bytearray(path.read_bytes())
            data[int(place * (len(data) - 1))] ^= 16
            path.write_bytes(bytes(data))

        return damage

    yield from (("first", flipped(0.0)), ("middle", flipped(0.5)), ("last", flipped(1.0)))
    yield "cut", lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    yield "empty", lambda path: path.write_bytes(b"")
    yield "missing", lambda path: path.unlink()
    yield "of another chunk", lambda path: shutil.copy(path.with_name(path.name.replace("1", "2", 1)), path)


@pytest.mark.parametrize(("name", "damage"), list(damages()), ids=lambda value: value if isinstance(value, str) else "")
@pytest.mark.parametrize("array", ["k", "frequencies (Hz)", "status", "checksum"])
def test_damage_is_found_and_mended(study, tmp_path, name, damage, array):
    sweep, path, whole = study
    arrays = [folder for folder in path.iterdir() if folder.is_dir()]
    chosen = [folder for folder in arrays if folder.name == array] or [
        folder for folder in arrays if folder.name.startswith("freq")
    ]
    copy = tmp_path / "k.zarr"
    shutil.copytree(path, copy)
    file = next(file for file in sorted((copy / chosen[0].name).iterdir()) if file.name[0] == "1")
    damage(file)
    is_same = bytes_of(copy) == bytes_of(path)
    result = sweep.run(store=copy)
    assert result.chunks.damaged == ([] if is_same or (array == "status" and name == "missing") else [1])
    assert result.to_xarray().load().identical(whole)
    assert bytes_of(copy) == bytes_of(path)


def test_damaged_labels_are_named(study, tmp_path):
    sweep, path, _ = study
    copy = tmp_path / "k.zarr"
    shutil.copytree(path, copy)
    (file,) = (file for file in (copy / "mode").iterdir() if file.name[0].isdigit())
    file.write_bytes(file.read_bytes()[:-1])
    with pytest.raises(mb.InputError, match=r"the store is damaged: mode is not as it was written"):
        sweep.run(store=copy)


def test_damaged_descriptions_are_named(study, tmp_path):
    sweep, path, _ = study
    for file in ("k/.zarray", ".zmetadata", "status/.zarray"):
        copy = tmp_path / file.replace("/", " ") / "k.zarr"
        shutil.copytree(path, copy)
        text = (copy / file).read_text("utf-8")
        (copy / file).write_text(text.replace('"shape"', '"sha1e"', 1), "utf-8")
        with pytest.raises(mb.InputError, match="the store is damaged"):
            sweep.run(store=copy)
