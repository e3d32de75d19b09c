"""What a running or killed engine leaves: a dump whose last frame is not all there."""

from __future__ import annotations

from collections.abc import Iterator

from demverify.errors import InputError
from demverify.frames import Frame


class HalfWrittenError(InputError):
    """The file ends inside a frame."""


def whole_frames(frames: Iterator[Frame], *, partial_ok: bool) -> Iterator[Frame]:
    """The frames; a half-written last one is passed over if `partial_ok`, else its HalfWrittenError goes on."""
    try:
        yield from frames
    except HalfWrittenError:
        if not partial_ok:
            raise
