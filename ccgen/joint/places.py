"""Where in the joint file a value stands, for those who find fault with it or propose another."""

from ccgen.joint.specification import Joint


def has_own_table(joint: Joint, axis: str) -> bool:
    """Whether the file has a table for the sensors of axis "u" or "v" alone."""
    return f"sensors.{axis}" in joint.own_keys


def sensor_key(joint: Joint, sensor: int, key: str) -> str:
    """Full name of the key of a transducer that a sensor has its value from.

    Args:
        joint: the joint.
        sensor: number in `joint.sensors`.
        key: such as "range".
    """
    own = own_place(joint, sensor, key)
    return own if own in joint.own_keys else f"sensors.transducer.{key}"


def radius_key(joint: Joint, sensor: int) -> str:
    """Full name of the key that a sensor, by its number in `joint.sensors`, has its radius from."""
    own = f"{_own_table(joint, sensor).removesuffix('.transducer')}.radius"
    return own if own in joint.own_keys else "sensors.radius"


def own_place(joint: Joint, sensor: int, key: str) -> str:
    """Full name that a key has or would have where it holds for that sensor, or its axis, alone."""
    return f"{_own_table(joint, sensor)}.{key}"


def _own_table(joint: Joint, sensor: int) -> str:
    """Where keys of that sensor's transducer stand that do not hold for all."""
    if joint.u is None and joint.v is None:
        return f"sensor[{sensor}]"
    axis = "u" if joint.u is not None and sensor < len(joint.u.spans) else "v"
    return f"sensors.{axis}.transducer"
