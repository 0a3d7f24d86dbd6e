# SPDX-License-Identifier: MIT
"""Uses the page in Chromium as a visitor does: presses by mouse and by keys, changes skin and body, saves a recording,
and has the native program press it again: it must come to the same hash. Then it is a phone. Keeps a screenshot.

    python3 page.py --page FOLDER --replay PROGRAM --out FOLDER
"""
import argparse
import gzip
import os
import pathlib
import re
import subprocess
import sys
import time

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

COMPRESSED = 500_000  # bytes at most
failed = []


def claim(text, holds, shown=""):
    print(f"{'ok    ' if holds else 'FAILED'} {text}{f': {shown}' if shown else ''}", flush=True)
    if not holds:
        failed.append(text)


def browser_at(page, downloads):
    options = webdriver.ChromeOptions()
    for argument in ["--headless=new", "--window-size=1240,1290", "--hide-scrollbars", "--disable-dev-shm-usage"]:
        options.add_argument(argument)
    if os.geteuid() == 0:  # Chromium refuses its sandbox to root
        options.add_argument("--no-sandbox")
    options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(options=options)
    browser.get((page / "index.html").as_uri())
    return browser


class Page:
    def __init__(self, browser, downloads):
        self.browser, self.downloads = browser, downloads

    def element(self, name):
        return self.browser.find_element(By.ID, name)

    def text(self, name):
        return self.element(name).text

    def wait_for(self, what, done, seconds=60):
        end = time.monotonic() + seconds
        while not done():
            if time.monotonic() > end:
                raise TimeoutError(f"{what} did not come in {seconds} s; the page says: {self.text('error')!r}")
            time.sleep(0.05)

    def steps(self):
        return self.browser.execute_script("return rows.length")

    def wait_steps(self, number):
        until = self.steps() + number
        self.wait_for(f"step {until}", lambda: self.steps() >= until)

    def greatest_force(self, steps):
        return self.browser.execute_script("return Math.max(...rows.slice(-arguments[0]).map(row => row[3]))", steps)

    def press_by_mouse(self, picture=None):
        skin = self.element("skin")
        if picture:  # of a body that moves
            self.browser.execute_script("""
                const last = rows.length + 45;
                const watch = setInterval(() => { if (rows.length >= last) { clearInterval(watch); pause(true); } }, 1);""")
        mouse = ActionChains(self.browser, duration=16).move_to_element_with_offset(skin, -80, -120).click_and_hold()
        for _ in range(60):
            mouse.move_by_offset(2, 3)
        mouse.perform()
        if picture:
            self.wait_for("the pause", lambda: self.element("pause").get_attribute("aria-pressed") == "true")
            self.browser.save_screenshot(str(picture))
            self.browser.execute_script("pause(false)")
        self.wait_steps(20)
        ActionChains(self.browser).release().perform()
        self.wait_steps(20)

    def press_by_keys(self):
        self.element("skin").send_keys("")  # focus
        keys = ActionChains(self.browser).key_down(" ").pause(0.3)
        for key in [Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_UP, Keys.ARROW_LEFT]:
            keys.send_keys(key).pause(0.05)
        keys.key_up(" ").perform()
        self.wait_steps(10)

    def choose(self, name, value):
        self.browser.execute_script("const [field, value] = arguments; field.value = value;"
                                    "for (const kind of ['input', 'change']) field.dispatchEvent(new Event(kind, {bubbles: true}));",
                                    self.element(name), value)

    def saved(self, name):
        """Pauses, saves the recording, and returns it with the hash that the page shows."""
        self.element("pause").click()
        shown = self.text("hash")
        for old in self.downloads.glob("*"):
            old.unlink()
        self.element("save").click()
        file = self.downloads / "dermis-recording.csv"
        self.wait_for("the recording", file.exists)
        kept = self.downloads.parent / name
        kept.write_bytes(file.read_bytes())
        return kept, shown


def check_same_bits(page, replay, name):
    file, shown = page.saved(name)
    answer = subprocess.run([replay, file], capture_output=True, text=True)
    native = re.fullmatch(r"(\d+) steps, (\d+) spikes, hash ([0-9a-f]{16})\n", answer.stdout)
    rows = file.read_text().splitlines()[2:]
    claim(f"{name}: the native program comes to the hash that the page shows",
          bool(native) and native[3] == shown and int(native[1]) == len(rows), answer.stdout.strip() + answer.stderr)
    numbers = [row.split(",") for row in rows]
    claim(f"{name}: the body has pressed, and SA1 fibres have fired",
          max(float(row[3]) for row in numbers) > 0.25 and sum(int(row[-3]) for row in numbers) > 0,
          f"{sum(int(row[-3]) for row in numbers)} spikes of SA1, {sum(int(row[-2]) for row in numbers)} of FA1, "
          f"{sum(int(row[-1]) for row in numbers)} of FA2")


def check_ghost(page):
    page.wait_steps(40)
    places = page.browser.execute_script("return rows.slice(-2).map(row => row[1])")
    claim("a finger presses and moves by itself before anyone does", page.greatest_force(40) > 0 and places[0] != places[1],
          page.text("status"))
    page.press_by_mouse()  # the browser compiles meanwhile
    page.element("restart").click()
    page.wait_steps(200)  # it pressed in each 3 s, which are 180 steps
    claim("after someone has pressed nothing presses by itself", page.greatest_force(200) == 0)


def check_fading(page):
    """After a press, while FA1 still answers."""
    was, now, answers = page.browser.execute_script("""
        const shown = () => quantities[3].shown.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
        quantities[3].shown.fill(1e3);  // more than any response
        for (let i = 0; i < 3; ++i) step();
        const was = shown();
        for (let i = 0; i < 9; ++i) step();
        return [was, shown(), quantities[3].most];""")
    claim("a map of FA1 fades on the screen to a tenth within 200 ms, and its numbers do not stay",
          300 < was < 900 and 99 < now < 101 and answers < 99, f"{was:.0f}, {now:.0f}, {answers:.2g}")


def check_words(page):
    found = page.browser.execute_script("return [...document.querySelectorAll('.words b, a')].map(e => e.textContent + (e.href || ''))")
    claim("a sentence says what each class answers to, and a link leads to the project",
          found[1:] == ["SA1", "SA2", "FA1", "FA2"] and found[0].endswith("/README.md"), " ".join(found))


def check_phone(page):
    """As on a phone of 390 x 844 points."""
    def swipe(x, y):
        places = [{"x": x, "y": y - 15 * i} for i in range(11)]
        for kind, points in [("Start", places[:1]), *[("Move", [place]) for place in places[1:]], ("End", [])]:
            page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})
        page.wait_steps(5)
        pressed = page.greatest_force(1000)
        return page.browser.execute_script("const down = scrollY; again(); scrollTo(0, 0); return down"), pressed

    page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                 {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True})
    page.browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
    page.browser.execute_script("again(); scrollTo(0, 0)")
    boxes = [page.element(name).rect for name in ("skin", "sa1", "sa2", "fa1", "fa2")]
    skin, seen = boxes[0], page.browser.execute_script("return [document.documentElement.scrollWidth, innerHeight]")
    ends = [box["y"] + box["height"] for box in boxes]
    claim("on a phone the skin and four maps are on the screen, the maps above the skin, and nothing is wider",
          seen == [390, 844] and ends[0] <= 844 and max(ends[1:]) <= skin["y"] and boxes[1]["y"] >= 0,
          ", ".join(f"{box['width']:.0f} x {box['height']:.0f} at {box['y']:.0f}" for box in boxes))
    middle = skin["y"] + skin["height"] / 2
    (below, _), (beside, idle), (on_skin, pressed) = swipe(20, 780), swipe(20, middle), swipe(195, middle)
    claim("a finger scrolls the page below and beside the skin, and presses on it",
          min(below, beside) > 100 and on_skin == idle == 0 and pressed > 0, f"{below:.0f}, {beside:.0f}, {on_skin:.0f} of 150")


def check_keys_reach(page):
    """Every control can be reached with the Tab key."""
    page.browser.execute_script("document.activeElement.blur()")
    reached = []
    for _ in range(14):
        ActionChains(page.browser).send_keys(Keys.TAB).perform()
        reached.append(page.browser.execute_script("return document.activeElement.id"))
    wanted = ["skin", "force", "shape", "radius", "ridges", "modulus", "surface", "material", "restart", "pause", "save"]
    claim("the Tab key reaches the skin and every control", [r for r in reached if r in wanted] == wanted, " ".join(reached))


def check_quiet(page):
    errors = [entry["message"] for entry in page.browser.get_log("browser") if entry["level"] == "SEVERE"]
    claim("the browser reports no error", not errors, "; ".join(errors))
    asked = set(re.findall(r'"url":"([a-z]+:[^"]*)"', " ".join(e["message"] for e in page.browser.get_log("performance"))))
    others = sorted(url for url in asked if not url.startswith(("file:", "data:", "blob:", "chrome:")))
    claim("the page asks for no address but its own folder's", not others, " ".join(others))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ["page", "replay", "out"]:
        parser.add_argument(f"--{name}", type=lambda text: pathlib.Path(text).resolve(), required=True)
    given = parser.parse_args()
    downloads = given.out / "downloads"
    downloads.mkdir(parents=True, exist_ok=True)
    size = sum(len(gzip.compress(file.read_bytes(), 9, mtime=0)) for file in given.page.iterdir())
    claim(f"the page has at most {COMPRESSED // 1000} KB, compressed", size <= COMPRESSED, f"{size / 1000:.0f} KB")
    browser = browser_at(given.page, downloads)
    try:
        page = Page(browser, downloads)
        page.wait_for("the first picture", lambda: page.text("hash"))
        check_ghost(page)
        check_words(page)
        page.element("restart").click()
        page.press_by_mouse(given.out / "page.png")
        page.press_by_keys()
        page.wait_steps(90)
        print("      " + page.text("speed"))
        check_same_bits(page, given.replay, "ridges.csv")
        page.choose("material", "1")
        page.choose("surface", "0")
        page.choose("modulus", "80")
        for shape, name in enumerate(["flat", "punch", "edge"]):
            page.choose("shape", str(shape))
            page.press_by_keys()
            check_same_bits(page, given.replay, f"{name}.csv")
        check_fading(page)  # while it pauses
        check_keys_reach(page)
        check_phone(page)
        check_quiet(page)
        claim("the page shows no error", not page.text("error"), page.text("error"))
    finally:
        browser.quit()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
