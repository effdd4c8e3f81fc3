"""Which files a joint's recordings are, by their content."""

import hashlib
from typing import TYPE_CHECKING

from ccgen.joint.recordings import CAN_LOGS
from ccgen.recordings.can_log import LARGEST_LOG
from ccgen.recordings.table import LARGEST_TEXT, read_bytes

if TYPE_CHECKING:
    from ccgen.joint import Joint


def recording_hashes(joint: "Joint") -> dict[str, str]:
    """SHA-256 of every file that the recordings of a joint name, by that name, hexadecimal.

    Raises:
        InputError: a file that cannot be read.
    """
    found = {}
    for recording in joint.recordings:
        for name in (recording.file, recording.counts, recording.dbc):
            if name is not None and name not in found:
                path = recording.path(name)
                most = LARGEST_LOG if path.suffix.lower() in CAN_LOGS else LARGEST_TEXT
                found[name] = hashlib.sha256(read_bytes(path, str(path), most)).hexdigest()
    return found
