"""Fixtures of the tests of the page: a small scene, `haarfield view` running on it, and headless Chromium."""

import base64
import contextlib
import json
import os
import re
import signal
import subprocess
import tempfile
import time

import numpy
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

PROGRAM = os.environ["HAARFIELD_PROGRAM"]
SOURCES = os.environ["HAARFIELD_SOURCE_DIR"]
LIGHTS = "/usr/share/blender/datafiles/studiolights/world"

PATIENCE = 60  # [s] for each wait, as machines may be busy

SCENE = """# Kept when the scene is saved.

[camera]
position = [1.3, 1.2, 1.9]
target = [0.0, 0.4, 0.0]
vertical_fov = 40.0
resolution = {resolution}

[environment]
image = "{lights}/interior.exr"

[materials.walnut]
diffuse = [0.30, 0.12, 0.05]
specular = [0.3, 0.3, 0.3]
shininess = 60
convention = "povray"

[materials.parquet]
pigment = [0.45, 0.38, 0.31]
finish = {{ diffuse = 0.9, phong = 0.2, phong_size = 30 }}

[entities.chair]
mesh = "{meshes}/chair.obj"
material = "walnut"
fine_vertices = 1500
coarse_triangles = 400
planar_samples = 200
spherical_samples = 200

[entities.floor]
mesh = "{meshes}/floor.obj"
material = "parquet"
fine_vertices = 900
coarse_triangles = 0

[[instances]]
entity = "floor"

[[instances]]
entity = "chair"

[[instances]]
entity = "chair"
translate = [0.9, 0.0, -0.5]
rotate = [0, 40, 0]
"""


def write_scene(folder, resolution=(160, 120)):
    file = os.path.join(folder, "room.toml")
    with open(file, "w") as scene:
        scene.write(SCENE.format(lights=LIGHTS, resolution=list(resolution), meshes=os.path.join(SOURCES, "scenes/meshes")))
    return file


class Server:
    """`haarfield view` on a scene in a temporary folder."""

    def __init__(self, scene, *options):
        self.scene = scene
        self.folder = os.path.dirname(scene)
        self.output = os.path.join(self.folder, "out")
        self.process = subprocess.Popen(
            [PROGRAM, "view", scene, "-o", self.output, "--lights", LIGHTS, "--quiet", *options],
            stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()
        if not self.url.startswith("http://127.0.0.1:"):
            raise RuntimeError("haarfield view said " + self.url)

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        code = self.process.wait(PATIENCE)
        self.process.stdout.close()
        return code


def started_browser(width=640, height=480):
    options = Options()
    for option in ["--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run",
                   "--disable-background-networking", "--disable-component-update", "--disable-sync",
                   "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                   f"--window-size={width},{height}",
                   "--user-data-dir=" + tempfile.mkdtemp(prefix="haarfield_browser_")]:
        options.add_argument(option)
    options.binary_location = "/usr/bin/chromium"
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    browser.set_script_timeout(PATIENCE)
    return browser


class Page:
    """The page in a window of the browser."""

    def __init__(self, browser, url):
        self.browser = browser
        self.url = url
        browser.get(url)
        self.window = browser.current_window_handle
        self.wait("return !!window.haarfield && haarfield.stats.frames > 0")

    def js(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def wait(self, script, *arguments, patience=PATIENCE):
        """Waits until a script returns a true value. Returns that value."""
        end = time.monotonic() + patience
        while True:
            value = self.js(script, *arguments)
            if value:
                return value
            if time.monotonic() > end:
                raise AssertionError(f"not so within {patience} s: {script}\n{self.trouble()}")
            time.sleep(0.02)

    def trouble(self):
        told = self.js("return window.haarfield ? JSON.stringify(haarfield.stats.errors) : 'no page'")
        log = [entry["message"] for entry in self.browser.get_log("browser")]
        return f"told: {told}\nlog: {log}"

    def send(self, type, **content):
        """Sends a message. Returns its number."""
        return self.js("return haarfield.connection.send(arguments[0], arguments[1])", type, content)

    def wait_exact(self, message=0):
        """Waits until the colours are exact and show a message."""
        self.wait("const {last, rest} = haarfield.stats;"
                  "return last && rest && rest.message >= arguments[0] && last.frame >= rest.frame &&"
                  " haarfield.stage.fadeStart + 300 < performance.now()", message)

    def settle(self):
        """Waits until all of the user's actions are shown exactly."""
        self.wait_exact(self.js("haarfield.connection.flush(); return haarfield.connection.number"))

    def objects(self):
        """Returns id and placement by name."""
        return self.js(
            "const list = {};"
            "for (const [id, {userData, position, quaternion, scale}] of haarfield.stage.objects)"
            " list[userData.name] = {id, position: position.toArray(), rotation: quaternion.toArray(),"
            " scale: scale.x};"
            "return list")

    def colours(self):
        """Returns, by name, the radiance at the vertices in the page's buffers."""
        packed = self.js(
            "const list = {};"
            "for (const {userData: {name, geometry}} of haarfield.stage.objects.values()) {"
            " const {array} = geometry.attributes.under;"
            " const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);"
            " let text = '';"
            " for (let i = 0; i < bytes.length; i += 8192)"
            "  text += String.fromCharCode(...bytes.subarray(i, i + 8192));"
            " list[name] = btoa(text);"
            "}"
            "return list")
        return {name: numpy.frombuffer(base64.b64decode(text), numpy.float16).astype(float).reshape(-1, 3)
                for name, text in packed.items()}

    def canvas_png(self):
        url = self.js("haarfield.stage.dirty = true; haarfield.stage.draw();"
                      "return document.getElementById('canvas').toDataURL('image/png')")
        return base64.b64decode(url.split(",")[1])

    def task(self, task, patience=PATIENCE):
        """Runs a task to its end. Returns its last message."""
        before = self.js("return haarfield.stats.tasks.length")
        self.send("start", task=task)
        return self.wait(
            "return haarfield.stats.tasks.slice(arguments[0])"
            ".find(({task, state}) => task === arguments[1] && state !== 'running')", before, task,
            patience=patience)


def baked_colours(scene, folder, fields):
    """Returns, by instance, the radiance at the vertices from a new `haarfield bake`."""
    report = os.path.join(folder, "report.json")
    subprocess.run([PROGRAM, "bake", scene, "-o", folder, "--fields", fields, "--error", "off", "--no-render",
                    "--format", "ply", "--quiet", "--report", report], check=True)
    with open(report) as file:
        mesh = json.load(file)["meshes"][0]
    with open(mesh, "rb") as file:
        data = file.read()
    header = data[:data.index(b"end_header\n") + 11].decode()
    count = int(re.search(r"element vertex (\d+)", header).group(1))
    types = {"float": "<f4", "uchar": "u1", "int": "<i4"}
    properties = re.findall(r"property (\w+) (\w+)\n", header[:header.index("element face")])
    vertex = numpy.dtype([(name, types[kind]) for kind, name in properties])
    vertices = numpy.frombuffer(data, vertex, count, len(header))
    radiance = numpy.stack([vertices[f"radiance_{channel}"] for channel in "rgb"], axis=1).astype(float)
    return [radiance[vertices["instance"] == i] for i in range(vertices["instance"].max() + 1)]


def relative_difference(a, b):
    """Returns the largest difference of two lists of colours, relative to colour plus a hundredth of the mean."""
    mean = numpy.mean(numpy.abs(b))
    return float(numpy.max(numpy.abs(a - b) / (numpy.abs(b) + 0.01 * mean)))


def instance_names(scene):
    """Returns the names in a saved scene, in order."""
    with open(scene) as file:
        return re.findall(r'^name = "(.*)"$', file.read(), re.MULTILINE)


@contextlib.contextmanager
def scratch():
    with tempfile.TemporaryDirectory(prefix="haarfield_view_") as folder:
        yield folder
