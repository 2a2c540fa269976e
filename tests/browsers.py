"""A browser to look with, and what happens in its pages."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pytest

SIZES = {"desktop": (1280, 900), "phone": (390, 844)}


@dataclass
class Visit:
    """A page opened without a network.

    Attributes:
        tab: the browser's page.
        requests: the addresses it asked for, its own aside.
        errors: what went wrong in it.
    """

    tab: Any
    requests: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def listen(self, address: str) -> None:
        """Note what goes wrong from now on, and what is asked for outside ``address``."""
        self.tab.on("pageerror", lambda error: self.errors.append(str(error)))
        self.tab.on("console", lambda m: self.errors.append(m.text) if m.type == "error" else None)
        self.tab.on("dialog", lambda dialog: self.errors.append(f"dialog {dialog.message}"))
        self.tab.on("request", lambda r: self._note(r.url, address))

    def _note(self, url: str, address: str) -> None:
        if not (url == address or (address.endswith("/") and url.startswith(address))):
            self.requests.append(url)

    def wait(self, condition: str) -> None:
        """Wait until an expression holds in the page, whose policy forbids playwright's own way."""
        for _ in range(1500):
            if self.tab.evaluate(condition):
                return
            self.tab.wait_for_timeout(20)
        pytest.fail(f"the page never came to {condition}")
