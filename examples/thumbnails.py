"""Write examples/thumbnails: a small picture of each scene for the index in README.md.

    python examples/thumbnails.py [SCENE ...]

It shows the model at a characteristic time, or the first plot of a scene without animation. The pictures of models need
Chromium. Without names all scenes are run, which takes some minutes.
"""

import io
import sys
from pathlib import Path

from PIL import Image

import mbconstrained as mb
from mbconstrained.page.photograph import photograph
from mbconstrained.page.plots import plot_image
from mbconstrained.scene.run.stages import is_animated

HERE = Path(__file__).parent
FOLDER = HERE / "thumbnails"

#: Sizes in pixels: of the files, and of the pictures before they are scaled down.
SIZE, WHOLE = (320, 200), (512, 320)

#: The part of its time at which a scene is shown, where it is not a tenth.
MOMENTS = {
    "rigid_link": 0.0,
    "inconsistent_start": 0.0,
    "quarter_car": 0.16,
    "pulled_joint": 0.604,
    "four_bar": 0.8,
    "seven_joint_arm": 0.9,
    "crane": 0.7,
    "flexible_arm": 0.4,
    "rotor": 0.35,
    "spindle": 0.35,
    "three_storeys": 0.31,
    "building_in_earthquake": 0.3,
}


def thumbnail(path: Path) -> Path:
    """Write the thumbnail of a scene."""
    result = mb.read_scene(path).run()
    if is_animated(result.scene):
        image = photograph(result.animation, MOMENTS.get(path.stem, 0.1) * float(result.times[-1]), *WHOLE)
    else:
        image = plot_image(result.page().plots[0], "png")
    picture = Image.open(io.BytesIO(image)).convert("RGB")
    whole = Image.new("RGB", SIZE, "white")
    picture.thumbnail(SIZE, Image.LANCZOS)
    whole.paste(picture, ((SIZE[0] - picture.width) // 2, (SIZE[1] - picture.height) // 2))
    file = FOLDER / f"{path.stem}.png"
    FOLDER.mkdir(exist_ok=True)
    whole.quantize(256).save(file, optimize=True)
    return file


if __name__ == "__main__":
    for scene in map(Path, sys.argv[1:] or sorted(HERE.glob("*.toml"))):
        print(thumbnail(scene).relative_to(HERE), flush=True)
