"""From pairs of images to a recording: in a file, or in the viewer's window."""

from __future__ import annotations

import importlib.util
import os
import secrets
import sys
import sysconfig
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from simtip.errors import InputError
from simtip.image_sets import Contents
from simtip.output_folder import PREFIX, check_new_file

if TYPE_CHECKING:
    import rerun as rr

NAME = "simtip"

ENDINGS = (".rrd",)

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


@dataclass(frozen=True)
class Destination:
    """Where a recording goes: to a new file, or, without one, into a window."""

    file: Path | None = None

    def check(self) -> None:
        """Refuse early what could not be written or opened.

        Raises
        ------
        InputError
            `simtip[viewer]` is not installed, the file exists or has no folder, or there is no
            display.
        """
        if importlib.util.find_spec("rerun") is None:
            raise InputError("simtip view needs rerun", remedy="pip install 'simtip[viewer]'")
        if self.file is not None:
            check_new_file(self.file, ENDINGS)
        elif sys.platform == "linux" and not any(map(os.environ.get, DISPLAYS)):
            raise InputError(
                "there is no display to open a window on",
                remedy="give --save FILE.rrd and open that where there is one",
            )


def show(
    contents: Contents, where: Destination, *, done: Callable[[], None] = lambda: None
) -> None:
    """Record pairs of images, one after the other.

    The timeline `trial` counts readings: a sweep's trials, or pairs that nothing was measured on.

    Parameters
    ----------
    contents
        The pairs.
    where
        File or window.
    done
        Called after each pair.

    Raises
    ------
    InputError
        See `Destination.check`; or a pair cannot be read, or the file not be written.
    """
    where.check()
    if where.file is not None:  # what goes wrong is said here, in one line
        os.environ.setdefault("RUST_LOG", "off")
    import rerun as rr

    recording = rr.RecordingStream(NAME, recording_id=uuid4())
    if where.file is None:
        _open_window(recording)
        _record(recording, contents, done)
        recording.flush()
        return
    temporary = where.file.parent / f"{PREFIX}{secrets.token_hex(8)}"
    try:
        recording.save(temporary)
        _record(recording, contents, done)
        recording.flush()
        recording.disconnect()
        temporary.rename(where.file)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be written ({reason})", file=where.file, remedy="name another file"
        ) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _open_window(recording: rr.RecordingStream) -> None:
    # The viewer is a program beside this interpreter, where PATH need not lead.
    places = [sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)]
    os.environ["PATH"] = os.pathsep.join(places)
    try:
        recording.spawn()
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[0].rstrip(".")
        raise InputError(
            f"the viewer cannot be opened ({reason})", remedy="give --save FILE.rrd instead"
        ) from error


def _record(recording: rr.RecordingStream, contents: Contents, done: Callable[[], None]) -> None:
    import rerun as rr

    from simtip.viewer.board import log_board
    from simtip.viewer.layout import layout
    from simtip.viewer.needle import log_needle, log_reading
    from simtip.viewer.paths import ERROR, TIMELINE, WORLD

    recording.log(WORLD, rr.ViewCoordinates.RDF, static=True)
    recording.log(ERROR, rr.SeriesPoints(), rr.SeriesLines(), static=True)
    count = 0
    for pair in (pair for one in contents.needles for pair in one.pairs()):
        for number, reading in enumerate(pair.readings or (None,)):
            recording.set_time(TIMELINE, sequence=count)
            if not count:
                recording.send_blueprint(layout(pair.truth.tip_mm, measured=True))
            if not number:
                log_needle(recording, pair)
            log_reading(recording, pair, reading)
            count += 1
        done()
    for board in (board for one in contents.boards for board in one.pairs()):
        recording.set_time(TIMELINE, sequence=count)
        if not count:
            recording.send_blueprint(layout(board.T_wt.t, measured=False))
        log_board(recording, board)
        count += 1
        done()
