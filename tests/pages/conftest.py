"""A real browser, and pages opened in it. There is no test of pages without one: where none starts, they fail."""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass, field

import pytest
from axe_playwright_python.sync_playwright import Axe

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
"""A picture without a graphics card, and no name that resolves."""
PATIENCE = 60.0
"""[s] that a busy machine may take to open a page."""


@pytest.fixture(scope="session")
def browser():
    found = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if found is None:
        pytest.fail("the tests of pages need Chromium: apt-get install chromium, or google-chrome on the PATH", False)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=found, args=list(FLAGS), timeout=1e3 * PATIENCE)
        yield started
        started.close()


@dataclass
class Opened:
    """A page, and what it said and asked for."""

    page: object
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def __call__(self, script: str, argument=None):
        """The value of an expression, or of a function of `argument`."""
        return self.page.evaluate(script, argument)

    def until(self, script: str) -> None:
        """Wait until an expression is true. Here, for in the page the policy forbids to wait for a text of code."""
        end = time.monotonic() + PATIENCE
        while not self(script):
            assert time.monotonic() < end, f"not true after {PATIENCE} s: {script}; the page said {self.said}"
            time.sleep(0.02)

    def barriers(self) -> list[str]:
        """What axe-core finds on the page that keeps people with disabilities from using it: serious and worse."""
        found = Axe().run(self.page, options={"resultTypes": ["violations"]}).response["violations"]
        grave = [one for one in found if one["impact"] in ("serious", "critical")]
        return [f"{one['id']}: {one['help']}; {node['html'][:200]}" for one in grave for node in one["nodes"]]


@pytest.fixture(scope="module")
def open_page(browser):
    """A function from a file, and optionally its hash and the size of the window, to an `Opened` page that is ready.
    At the end no page may have said anything, or asked for anything but itself."""
    pages: list[tuple[Opened, object]] = []

    def open_it(path, link="", *, wide=1280, tall=800, before="") -> Opened:
        context = browser.new_context(viewport={"width": wide, "height": tall}, offline=True)
        opened = Opened(context.new_page())
        opened.page.set_default_timeout(1e3 * PATIENCE)
        opened.page.on("console", lambda message: opened.said.append(message.text))
        opened.page.on("pageerror", lambda error: opened.said.append(str(error)))
        opened.page.on("request", lambda request: opened.asked.append(request.url))
        opened.page.add_init_script(
            "addEventListener('securitypolicyviolation', (e) => console.log(`policy: ${e.blockedURI}`));" + before
        )
        opened.page.goto(f"{path.as_uri()}{link}", wait_until="commit")
        opened.until("globalThis.ready === true")
        pages.append((opened, context))
        return opened

    yield open_it
    for opened, context in pages:
        context.close()
        assert opened.said == []
        assert len([url for url in opened.asked if not url.startswith(("data:", "blob:"))]) == 1
