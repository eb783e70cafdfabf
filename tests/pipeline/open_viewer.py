"""Opens the viewer's page in headless Chromium and prints as JSON how it answers. Runs under Debian's
Python, for which python3-selenium is installed: open_viewer.py ADDRESS [FOLDER for screenshots]"""
import json
import pathlib
import sys
import time

from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

from open_report import start

WAIT_S = 60


def wait_for_full_picture(browser, before):
    """The page's facts once it is at rest and shows a later picture than number `before`."""
    deadline = time.monotonic() + WAIT_S
    while time.monotonic() < deadline:
        facts, is_busy = browser.execute_script(
            "return [{...document.body.dataset}, document.querySelector('canvas').ariaBusy !== 'false']")
        if not is_busy and facts.get("pictures") != before:
            return facts
        time.sleep(0.05)
    raise TimeoutError("no full picture: " + browser.find_element(By.CSS_SELECTOR, "[role=status]").text)


def picture(browser):
    """Hash and number of colours of what the canvas shows; the page counts, since pixels are slow to fetch."""
    return browser.execute_async_script("""
        const finish = arguments[0];
        const canvas = document.querySelector('canvas'), {width, height} = canvas;
        const copy = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
        copy.drawImage(canvas, 0, 0);
        const pixels = copy.getImageData(0, 0, width, height).data, colors = new Set();
        for (let i = 0; i < pixels.length; i += 4 * 17) colors.add(pixels.slice(i, i + 3).join());
        crypto.subtle.digest('SHA-256', pixels).then(
            hash => finish([new Uint8Array(hash).join(), colors.size]))""")


def drag(browser, canvas):
    """Drags in small steps; returns how long the answers to drafts took [ms]."""
    times = []
    browser.execute_script("delete document.body.dataset.draftMs")
    chain = ActionChains(browser, duration=20).click_and_hold(canvas)
    chain.perform()
    for _ in range(12):
        ActionChains(browser, duration=20).move_by_offset(6, 2).perform()
        time.sleep(0.1)
        draft_ms = browser.execute_script("return document.body.dataset.draftMs")
        if draft_ms:
            times.append(int(draft_ms))
    ActionChains(browser).release().perform()
    return times


def fall_silent(browser):
    """The page's message while the server does not answer, once it has noticed; then that it is gone."""
    message = browser.find_element(By.CSS_SELECTOR, "[role=status]")

    def wait_for(is_right):
        deadline = time.monotonic() + WAIT_S
        while not is_right(message.text):
            if time.monotonic() > deadline:
                raise TimeoutError("the message is still: " + message.text)
            time.sleep(0.05)
        return message.text

    browser.execute_script("window.realFetch = fetch; window.fetch = () => Promise.reject(new TypeError())")
    silence = wait_for(bool)
    browser.execute_script("window.fetch = window.realFetch")
    wait_for(lambda text: not text)
    return silence


def look(page, width, scheme, screenshots):
    browser = start(width)
    try:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": scheme}]})
        browser.get(page)
        canvas = browser.find_element(By.TAG_NAME, "canvas")
        pictures, shown = [], None

        def take_picture():
            nonlocal shown
            shown = wait_for_full_picture(browser, shown)["pictures"]
            pictures.append(picture(browser))

        take_picture()
        times = drag(browser, canvas)
        take_picture()
        canvas.send_keys(Keys.ARROW_LEFT * 3)
        take_picture()
        canvas.send_keys(Keys.SHIFT + Keys.ARROW_LEFT)
        take_picture()
        canvas.send_keys("N")  # as with Caps Lock
        take_picture()
        if screenshots:
            browser.save_screenshot(str(screenshots / f"viewer_{width}_{scheme}.png"))
        for mode in ("depth", "size of tets", "slice", "error", "photo"):
            Select(browser.find_element(By.NAME, "mode")).select_by_visible_text(mode)
            take_picture()
            if screenshots and scheme == "light":
                browser.save_screenshot(str(screenshots / f"viewer_{width}_{mode.split()[-1]}.png"))
        canvas.send_keys("n")  # from photo to photo: no request on the way may be refused (console)
        take_picture()
        # The button that was clicked has the focus, and keys work there, too.
        browser.find_element(By.NAME, "next").click()
        take_picture()
        for key in ("n", Keys.SPACE, Keys.ARROW_LEFT):  # Space presses the button
            browser.switch_to.active_element.send_keys(key)
            take_picture()
        silence = fall_silent(browser)
        return {
            "pictures": pictures, "draft_ms": times, "silence": silence,
            "message": browser.find_element(By.CSS_SELECTOR, "[role=status]").text,
            "too_wide_px": browser.execute_script(
                "return document.documentElement.scrollWidth - innerWidth"),
            "console": [entry["message"] for entry in browser.get_log("browser")]}
    finally:
        browser.quit()


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    print(json.dumps({f"{width} {scheme}": look(sys.argv[1], width, scheme, folder)
                      for width, scheme in ((400, "dark"), (1280, "light"))}))
