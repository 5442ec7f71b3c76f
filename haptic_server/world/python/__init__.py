"""World and SceneWorld compute forces in this process; Scene is what a scene file says, and haptics.scene has all that one may
say; haptics.v1 holds the protocol's messages, for haptic_client."""
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from haptics.scene import Scene

_OF_WORLD = ("Body", "Device", "Fault", "Material", "Pose", "SAMPLE", "SceneWorld", "TOOL_SAMPLE", "Tool",
             "World")


def __getattr__(name):
    # A client of a server needs neither numpy nor the compiled module, and a World no messages.
    if name == "Scene":
        from haptics.scene import Scene
        return Scene
    if name not in _OF_WORLD:
        raise AttributeError(f"module 'haptics' has no attribute {name!r}")
    from haptics import _world
    return getattr(_world, name)


def __dir__():
    return sorted([*globals(), *_OF_WORLD, "Scene"])
