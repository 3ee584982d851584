"""Drops files on a window, as a file manager does: a drag source of the protocol XDND (freedesktop.org, "Drag-and-Drop Protocol for the
X Window System"), version 5, for `try.py`."""

import pathlib
import time
import urllib.parse

from Xlib import X, display
from Xlib.protocol import event

VERSION = 5
# Timeout of the window's answers, in seconds: it answers between two frames.
PATIENCE = 60


class Drag:
    """A drag of files over the window with an id, from XdndEnter on."""

    def __init__(self, window, files):
        self.display = display.Display()
        self.window = self.display.create_resource_object("window", int(window))
        root = self.display.screen().root
        self.source = root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
        uris = ["file://" + urllib.parse.quote(str(pathlib.Path(file).resolve())) for file in files]
        self.uris = "".join(uri + "\r\n" for uri in uris).encode()
        # Other programs query the selection's owner for the dragged data.
        self.source.set_selection_owner(self.atom("XdndSelection"), X.CurrentTime)
        self.send("XdndEnter", VERSION << 24, self.atom("text/uri-list"), 0, 0)

    def atom(self, name):
        return self.display.intern_atom(name)

    def send(self, kind, *data):
        numbers = (32, [self.source.id, *data])
        message = event.ClientMessage(window=self.window, client_type=self.atom(kind), data=numbers)
        self.window.send_event(message)
        self.display.flush()

    def answer(self, kind):
        """Sends the files' names when the window requests them, until a message of this kind arrives; returns its flags."""
        end = time.time() + PATIENCE
        while time.time() < end:
            if not self.display.pending_events():
                time.sleep(0.02)
                continue
            came = self.display.next_event()
            if came.type == X.SelectionRequest:
                self.hand(came)
            elif came.type == X.ClientMessage and came.client_type == self.atom(kind):
                return came.data[1]
        raise AssertionError(f"the window does not answer with {kind} within {PATIENCE} s")

    def hand(self, request):
        request.requestor.change_property(request.property, request.target, 8, self.uris)
        request.requestor.send_event(event.SelectionNotify(
            time=request.time, requestor=request.requestor, selection=request.selection, target=request.target,
            property=request.property))
        self.display.flush()

    def over(self, x, y):
        """Moves the drag to a position of the display; asserts that the window accepts the files."""
        self.send("XdndPosition", 0, x << 16 | y, X.CurrentTime, self.atom("XdndActionCopy"))
        _, flags, *_ = self.answer("XdndStatus")
        is_taken = flags & 1
        assert is_taken, "the window accepts no files"

    def leave(self):
        self.send("XdndLeave", 0, 0, 0, 0)
        self.display.close()

    def drop(self):
        self.send("XdndDrop", 0, X.CurrentTime, 0, 0)
        self.answer("XdndFinished")
        self.display.close()


def dropped(window, files, at=(800, 400)):
    """Drags files over a window and drops them there."""
    drag = Drag(window, files)
    drag.over(*at)
    drag.drop()
