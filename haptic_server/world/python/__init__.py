"""World and SceneWorld compute forces in this process; haptics.v1 holds the protocol's messages, for haptic_client."""

_OF_WORLD = ("Body", "Device", "Fault", "Material", "Pose", "SAMPLE", "SceneWorld", "TOOL_SAMPLE", "Tool",
             "World")


def __getattr__(name):
    # A client of a server needs neither numpy nor the compiled module.
    if name not in _OF_WORLD:
        raise AttributeError(f"module 'haptics' has no attribute {name!r}")
    from haptics import _world
    return getattr(_world, name)


def __dir__():
    return sorted([*globals(), *_OF_WORLD])
