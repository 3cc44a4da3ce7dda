"""A headless browser for the page of `view`, if there is one."""

import shutil

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)


def browser_flags(width: int, height: int) -> tuple[str, ...]:
    """Flags for a window of so many pixels, WebGL without a graphics card."""
    return (
        *("--headless", "--no-sandbox", "--hide-scrollbars", f"--window-size={width},{height}"),
        *("--virtual-time-budget=2000", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    )
