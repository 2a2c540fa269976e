"""An interrupt is heard wherever it comes, also where Python drops exceptions."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import ctypes, gc, os, signal, sys, time, weakref
from gm_ompl.app.interrupts import listen

def end():
    os.kill(os.getpid(), signal.{signal})
    for _ in range(10):
        time.sleep(0.01)

class Doomed:
    def __del__(self):
        end()

class Plain:
    pass

def callback():
    ctypes.CFUNCTYPE(None)(end)()

def finaliser():
    Doomed()

def weak():
    thing = Plain()
    watch = weakref.ref(thing, lambda _: end())
    del thing

def collector():
    gc.callbacks.append(lambda phase, _: end() if phase == "stop" else None)
    gc.collect()
    gc.callbacks.clear()

listen()
try:
    {where}()
    for _ in range(200):
        time.sleep(0.01)
except KeyboardInterrupt:
    sys.exit(7)
"""


@pytest.mark.parametrize("where", ["end", "callback", "finaliser", "weak", "collector"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupt_is_heard(where: str, name: str) -> None:
    """In a callback from C, a finaliser, the collector: soon after it, and nothing is said."""
    program = PROGRAM.format(where=where, signal=name)
    done = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, timeout=60)
    assert (done.returncode, done.stderr) == (7, b"")
