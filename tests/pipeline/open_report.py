"""Opens a report in headless Chromium and prints as JSON how it answers. Runs under Debian's Python, for
which python3-selenium is installed: open_report.py report.html"""
import hashlib
import json
import sys
import time

from selenium import webdriver
from selenium.webdriver import ActionChains
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

WAIT_S = 60


def start(width):
    options = Options()
    options.binary_location = "/usr/bin/chromium"
    # Software WebGL; without a sandbox, which root and containers cannot have.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle",
                     "--use-angle=swiftshader", "--enable-unsafe-swiftshader"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
    return browser


def picture(browser, element):
    time.sleep(0.5)  # two frames of a busy machine
    return hashlib.sha256(element.screenshot_as_png).hexdigest()


def look(page, width):
    browser = start(width)
    try:
        browser.get(page)
        scene = browser.find_element(By.CSS_SELECTOR, ".scene")
        deadline = time.monotonic() + WAIT_S
        while scene.get_attribute("data-state") == "loading" and time.monotonic() < deadline:
            time.sleep(0.05)
        canvas = scene.find_element(By.TAG_NAME, "canvas")
        facts = {"state": scene.get_attribute("data-state"),
                 "message": scene.find_element(By.CSS_SELECTOR, "[role=status]").text}
        # The outline of what has the focus would make any two pictures differ.
        browser.execute_script("arguments[0].style.outline = 'none'; arguments[0].focus()", canvas)
        pictures = [picture(browser, canvas)]
        canvas.send_keys(Keys.ARROW_LEFT * 5)
        pictures.append(picture(browser, canvas))
        canvas.send_keys("+")
        pictures.append(picture(browser, canvas))
        ActionChains(browser).drag_and_drop_by_offset(canvas, 60, 10).perform()
        pictures.append(picture(browser, canvas))
        for name, keys in (("look", "grey"), ("cameras", " "), ("from", Keys.ARROW_DOWN)):
            scene.find_element(By.NAME, name).send_keys(keys)
            pictures.append(picture(browser, canvas))
        facts["pictures"] = pictures
        compare = browser.find_element(By.CSS_SELECTOR, ".view")
        slider = compare.find_element(By.CSS_SELECTOR, ".slider")
        slider.send_keys(Keys.ARROW_LEFT * 10)
        facts["slider"] = browser.execute_script(
            "return arguments[0].querySelector('.compare').style.getPropertyValue('--at')", compare)
        facts["too_wide_px"] = browser.execute_script(
            "return document.documentElement.scrollWidth - innerWidth")
        facts["console"] = [entry["message"] for entry in browser.get_log("browser")]
        return facts
    finally:
        browser.quit()


if __name__ == "__main__":
    print(json.dumps({width: look("file://" + sys.argv[1], width) for width in (400, 1280)}))
