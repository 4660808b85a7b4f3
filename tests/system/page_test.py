#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page in a headless Chromium: page_test.py GEOND SOURCE_FOLDER PAGE_FOLDER [PICTURES]. Ends with 77 where there is no
browser or the page was not built. With a folder PICTURES, screenshots are left there."""
import json
import os
import re
import subprocess
import sys
import tempfile
import urllib.request

from browser import Browser, program

geond, source, page = sys.argv[1:4]
pictures = sys.argv[4] if len(sys.argv) > 4 else None
if not program():
    print("skipped: there is no Chromium on this machine (apt install chromium)")
    sys.exit(77)
if not os.path.exists(os.path.join(page, "three.module.js")):
    print("skipped: the page was not built (cmake --build BUILD --target page; it needs npm)")
    sys.exit(77)


def check(holds, sentence):
    if not holds:
        sys.exit("FAILED: " + sentence)


def shot(browser, name):
    return browser.screenshot(os.path.join(pictures, name + ".png") if pictures else None)


def call(method, **params):
    request = urllib.request.Request(url + "/rpc", json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}).encode(),
                                     {"Content-Type": "application/json"})
    return json.load(urllib.request.urlopen(request))["result"]


# The colours of the first two parts, in any light.
def blue(r, g, b):
    return b > 120 and b > r + 50 and b > g + 25


def orange(r, g, b):
    return r > 120 and r > g + 45 and g > b + 15


folder = tempfile.TemporaryDirectory()
# The sample object before a camera of few pixels, which is soon computed.
with open(folder.name + "/sim.toml", "w") as file:
    file.write(f'scene = "{os.path.abspath(source)}/config/scenes/bowling_pin.toml"\n[rangefinder]\ncolumns = 140\nrows = 140\n')
service = subprocess.Popen(
    [geond, "--config", os.path.join(source, "config", "geond.toml"), "--set", "api.unix_socket=" + folder.name + "/socket",
     "--set", "api.port=0", "--set", "http.port=0", "--set", "robot.port=-1", "--set", "http.page=" + os.path.abspath(page),
     "--set", "store.folder=" + folder.name + "/store", "--set", "station.simulation=" + folder.name + "/sim.toml", "--set", "scan.triangles=1200", "--set", "scan.picture=false"],
    stderr=subprocess.PIPE, text=True)
browser = None
try:
    url = None
    for line in service.stderr:
        found = re.search(r"the page is at (http://\S+)", line)
        if found:
            url = found.group(1)
            break
    rest = subprocess.Popen(["cat"], stdin=service.stderr, stdout=subprocess.DEVNULL)

    # From the click to the description.
    browser = Browser(1280, 800)
    browser.open(url)
    browser.wait("document.body.dataset.ready")
    check("idle" in browser.js("document.getElementById('state').textContent"), "the station is not idle")
    browser.click_on("#scan")
    browser.wait("document.body.dataset.shown === '1'")
    check(browser.js("[...document.querySelectorAll('.part b')].map((b) => b.textContent)") == ["ellipsoid", "tapered cylinder"],
          "the parts are not those of the pin")
    check(browser.js("document.querySelectorAll('#scans tr').length") == 1, "the history does not show one scan")
    geons = shot(browser, "geons")
    (much_blue, (_, blue_y)), (much_orange, (_, orange_y)) = geons.where(blue), geons.where(orange)
    check(0.03 < much_blue < 0.3 and 0.015 < much_orange < 0.2, f"the picture is {much_blue:.3f} blue, {much_orange:.3f} orange")
    check(orange_y < blue_y, "the neck is not above the body")

    # A click into the picture opens the part it hits, with all seven residuals.
    place = browser.js("(() => { const b = document.querySelector('#view canvas').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()")
    browser.click(place[0] + place[2] / 2, place[1] + 0.62 * place[3])
    check(browser.wait("document.querySelector('.part.chosen b')?.textContent") == "ellipsoid", "the click hit another part")
    check(browser.js("document.querySelectorAll('.part.chosen .residuals tr').length") == 7, "there are not seven residuals")
    check(browser.js("new Set([...document.querySelectorAll('.part.chosen .residuals td:first-child')].map((d) => d.textContent)).size") == 7,
          "the seven residuals are not of seven shapes")

    # Each layer changes the picture.
    for layer in ("cloud", "charge", "parts", "grasps"):
        browser.js(f"document.getElementById('layer-geons').checked && document.getElementById('layer-geons').click(),"
                   f"document.getElementById('layer-{layer}').click()")
        picture = shot(browser, layer)
        drawn = picture.where(lambda r, g, b: max(r, g, b) - min(r, g, b) > 40)[0]
        check(drawn > 0.02, f"the layer {layer} shows nothing ({drawn:.4f})")
        browser.js(f"document.getElementById('layer-{layer}').click()")
    browser.js("document.getElementById('layer-geons').click()")

    # A fault is shown in words, and its mending.
    call("simulation.fault", device="turntable", fault="off")
    browser.click_on("#scan")
    browser.wait("document.getElementById('message').textContent.includes('turntable')")
    browser.wait("document.getElementById('state').classList.contains('wrong')")
    shot(browser, "fault")
    call("simulation.fault", device="turntable", fault="none")
    browser.click_on("#reset")
    browser.wait("document.getElementById('state').textContent === 'idle'")
    check(browser.js("document.getElementById('message').textContent") == "", "the message stays after the fault is mended")

    # A reload in mid-scan finds the scan again and its end.
    browser.js("document.body.dataset.shown = ''")
    browser.click_on("#scan")
    browser.wait("!document.getElementById('progress').hidden")
    browser.open(url)
    browser.wait("document.body.dataset.ready && (!document.getElementById('progress').hidden || document.body.dataset.shown === '3')")
    shot(browser, "reload")
    browser.wait("document.body.dataset.shown === '3'")
    browser.wait("document.getElementById('progress').hidden")
    check(browser.js("[...document.querySelectorAll('#scans tr')].map((row) => row.dataset.scan + row.classList[0])") ==
          ["3done", "2failed", "1done"], "the history is not right")

    # Pinned by a click.
    browser.js("[...document.querySelectorAll('#scans tr.done button')].find((b) => b.textContent === 'pin').click()")
    browser.wait("[...document.querySelectorAll('#scans button')].some((b) => b.textContent === 'unpin')")
    check(call("scan.status", scan=3)["pinned"] is True, "the scan is not pinned")
    wrong = [line for line in browser.log if "exception" in line.lower() or '"level": "error"' in line]
    check(not wrong, f"the page complains: {wrong}")
    browser.close()

    # On a phone nothing is wider than the screen, and the buttons are large enough for a thumb.
    browser = Browser(390, 844, phone=True)
    browser.open(url)
    browser.wait("document.body.dataset.shown === '3'")
    shot(browser, "phone")
    check(browser.js("document.documentElement.scrollWidth") <= 390, "the page is wider than a phone")
    check(browser.js("Math.min(...[...document.querySelectorAll('.buttons button')].map((b) => b.getBoundingClientRect().height))") >= 36,
          "the buttons are too small")
    service.terminate()
    check(service.wait(30) == 0, "geond did not end well")
finally:
    if browser:
        browser.close()
    if service.poll() is None:
        service.kill()
print("the page scans, shows, tells faults and survives a reload")
