"""The LumpedModel of the tables of a lumped scene."""

from __future__ import annotations

from ...ground.errors import InputError
from ...models.lumped import LumpedModel
from ..file.messages import at


def lumped_model(table, file_name: str) -> LumpedModel:
    """The model: bodies first, in the order of the file, then what joins them; a SceneError names the file and the entry."""
    model = LumpedModel()
    for key, number, entry in table.elements:
        owner = f' (of "{entry.name}")' if entry.name else ""
        with at(file_name, f"model.{key}[{number}]{owner}"):
            add = model.constrain if key == "constraint" else getattr(model, key)
            add(**entry.given)
    joined = {name for element in model.elements for name in element.ends}
    for number, node in enumerate(table.node, 1):
        if node.name not in joined:
            with at(file_name, f'model.node[{number}] (of "{node.name}")'):
                raise InputError(
                    "nothing is attached to this joint, which has no mass, so that its position is undetermined; join it by a spring, "
                    "a damper or a constraint, or take it out"
                )
    if table.gravity is not None:
        with at(file_name, "model.gravity"):
            model.gravity(table.gravity)
    return model
