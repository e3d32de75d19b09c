"""Pages in a browser without a screen: what their programs left in the page."""

from __future__ import annotations

import html
import re
import shutil
import subprocess
from pathlib import Path

CHROMIUM = shutil.which("chromium")
_OFFLINE = ("--disable-background-networking", "--disable-component-update", "--disable-quic", "--disable-sync", "--no-first-run")
_DRAWING = ("--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def opened(page: Path, script: str = "", options: tuple[str, ...] = _DRAWING) -> dict[str, str]:
    """Opens a page, with a script after its own, and gives the data attributes of its root, and the text of its alert as `alert`."""
    assert CHROMIUM
    copy = page.with_name(f"opened-{page.name}")
    copy.write_text(page.read_text(encoding="utf-8").replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    words = ("--headless", "--no-sandbox", f"--user-data-dir={page.parent / 'browser'}", *_OFFLINE, *options, "--virtual-time-budget=3000")
    done = subprocess.run([CHROMIUM, *words, "--window-size=800,800", "--dump-dom", copy.as_uri()], capture_output=True, text=True, check=True)
    root = re.search(r"<html[^>]*>", done.stdout)
    alert = re.search(r'<p id="message" role="alert"(?P<hidden> hidden="")?>(?P<text>[^<]*)', done.stdout)
    assert root
    assert alert
    return {name: html.unescape(value) for name, value in re.findall(r'data-(\w+)="([^"]*)"', root[0])} | {"alert": alert["text"]}
