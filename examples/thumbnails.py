"""Makes examples/thumbnails: a small picture of each scene for the index in README.md.

    python examples/thumbnails.py [SCENE ...]

It shows the model at a time when something is to be seen; of a scene without places, its first plot. A Chromium takes the
pictures of models. Without names all scenes are run, which takes some minutes.
"""

import io
import sys
from pathlib import Path

from PIL import Image

import mbconstrained as mb
from mbconstrained.page.photograph import photograph
from mbconstrained.page.plot_images import plot_images
from mbconstrained.scene.output_decisions import is_animated
from mbconstrained.scene.report import page_content

HERE = Path(__file__).parent
FOLDER = HERE / "thumbnails"

#: Of the files, in pixels, and of the pictures that they are made from, on which names are larger.
SIZE, TAKEN = (320, 200), (512, 320)

#: The part of its time at which a scene is shown, where it is not a tenth.
MOMENTS = {
    "rigid_link": 0.0,
    "inconsistent_start": 0.0,
    "quarter_car": 0.16,
    "pulled_joint": 0.604,
    "four_bar": 0.8,
    "seven_joint_arm": 0.9,
}


def thumbnail(path: Path) -> Path:
    """The file of a scene, which is made anew."""
    result = mb.read_scene(path).run()
    if is_animated(result.scene):
        taken = photograph(result.animation, MOMENTS.get(path.stem, 0.1) * float(result.times[-1]), *TAKEN)
    else:
        taken = plot_images(page_content(result).plots)[0].rendered("png")
    picture = Image.open(io.BytesIO(taken)).convert("RGB")
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
