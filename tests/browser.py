"""A headless Chromium for tests of pages."""

import base64
import shutil
from pathlib import Path

import pytest

DRIVERS, BROWSERS = ("chromedriver",), ("chromium", "chromium-browser", "google-chrome")
# Resolves after two frames, when all that was asked for has been drawn.
DRAWN = (
    "const done = arguments[arguments.length - 1]; requestAnimationFrame(() => requestAnimationFrame(() => done()));"
)


def found(names):
    return next((path for path in map(shutil.which, names) if path), None)


def started():
    """A browser; without one the test is skipped."""
    try:
        from selenium import webdriver
    except ImportError as error:
        pytest.skip(f"selenium is not installed, so that no page is opened in a browser: {error}")
    driver, browser = found(DRIVERS), found(BROWSERS)
    if driver is None or browser is None:
        pytest.skip("chromium and chromedriver are not installed, so that no page is opened in a browser")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))


class Browser:
    """A browser at one page."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, path, width=1280, height=900, dark=False, print_=False, scripts=True):
        """Open a file in a window of some size, and wait until the mesh, if it has one, is drawn."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.command("Emulation.setDeviceMetricsOverride", **size)
        self.command("Emulation.setScriptExecutionDisabled", value=not scripts)
        self.media(dark, print_)
        self.driver.get_log("browser")
        self.driver.get(Path(path).as_uri())
        if scripts and self.js("return document.getElementById('mesh') !== null"):
            self.wait("return document.documentElement.dataset.ready")
        if scripts:
            self.drawn()

    def media(self, dark=False, print_=False):
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.command("Emulation.setEmulatedMedia", media="print" if print_ else "screen", features=[scheme])

    def command(self, name, **arguments):
        return self.driver.execute_cdp_cmd(name, arguments)

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait(self, script, seconds=20):
        from selenium.webdriver.support.ui import WebDriverWait

        return WebDriverWait(self.driver, seconds, poll_frequency=0.02).until(
            lambda driver: driver.execute_script(script)
        )

    def drawn(self):
        """Wait until what was asked for is drawn."""
        self.driver.execute_async_script(DRAWN)

    def find(self, selector):
        return self.driver.find_element("css selector", selector)

    def click(self, selector):
        self.js("arguments[0].click()", self.find(selector))
        self.drawn()

    def text(self, selector):
        return self.js("return arguments[0].textContent", self.find(selector))

    def complaints(self):
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def pdf(self):
        return base64.b64decode(self.command("Page.printToPDF", printBackground=True)["data"])
