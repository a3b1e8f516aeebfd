"""The page of `haarfield view` in a real browser: gestures of users, and the displayed results."""

import base64
import http.server
import io
import math
import os
import random
import subprocess
import threading
import time
import unittest

from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import browser as view


LAMP = """
[[lights]]
name = "bulb"
position = [0.5, 1.5, 0.5]
colour = [1, 1, 1]
"""


class PageTest(unittest.TestCase):
    """Tests that share one server and one browser. Each begins with a page that displays exact colours."""

    @classmethod
    def setUpClass(cls):
        cls.browser = view.started_browser()
        cls.scratch = view.scratch()
        cls.server = view.Server(view.write_scene(cls.scratch.__enter__()))
        cls.page = view.Page(cls.browser, cls.server.url)

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        cls.browser.quit()
        cls.scratch.__exit__(None, None, None)

    def setUp(self):
        self.page.wait_exact()
        self.page.js("haarfield.stats.errors.length = 0; haarfield.panel.on.tool('look')")

    def assert_same(self, a, b, tolerance=1e-3):
        self.assertEqual(a.keys(), b.keys())
        for name in a:
            self.assertLess(view.relative_difference(a[name], b[name]), tolerance, name)

    def assert_bakes_alike(self, name):
        """Saves the scene under a name. A bake of the file must equal the colours of the page."""
        self.page.wait_exact(self.page.send("save", name=name))
        scene = os.path.join(self.server.folder, name + ".toml")
        self.page.wait("return haarfield.stats.saved === arguments[0]", scene)
        baked = view.baked_colours(scene, os.path.join(self.server.folder, "bake_" + name),
                                   os.path.join(self.server.output, "fields"))
        self.assert_same(self.page.colours(), dict(zip(view.instance_names(scene), baked)))
        return scene

    def test_shows_what_bake_makes(self):
        self.assert_bakes_alike("as_opened")

    def test_sliders_turn_the_light_and_undo_turns_it_back(self):
        before = self.page.colours()
        slider = self.browser.find_element(By.ID, "turn")
        slider.send_keys(Keys.ARROW_RIGHT * 40)
        self.page.settle()
        self.assertAlmostEqual(self.page.js("return haarfield.light().rotation[1]"), 0.342, 2)
        turned = self.page.colours()
        self.assertGreater(view.relative_difference(turned["floor"], before["floor"]), 0.05)
        self.assert_bakes_alike("turned")
        # Each key press is a separate gesture.
        while not self.page.js("return document.getElementById('undo').disabled"):
            self.page.wait_exact(self.page.send("undo"))
            if self.page.js("return Math.abs(haarfield.light().rotation[1]) < 1e-9"):
                break
        self.page.wait_exact()
        self.assert_same(self.page.colours(), before)

    def test_the_light_turns_about_any_axis_by_its_gizmo(self):
        before = self.page.js("return haarfield.light().rotation")
        self.page.js("haarfield.panel.on.tool('light')")
        self.drag_gizmo("X", self.ring_direction())
        self.page.wait("return Math.abs(haarfield.light().rotation[0] - arguments[0]) > 0.02", before[0])
        self.page.settle()
        self.assert_bakes_alike("tilted")
        self.page.wait_exact(self.page.send("undo"))
        self.assertEqual(self.page.js("return haarfield.light().rotation"), before)

    def test_a_dropped_panorama_lights_the_scene(self):
        with open(os.path.join(view.LIGHTS, "studio.exr"), "rb") as file:
            self.drop("my studio.exr", file.read())
        self.page.wait("return haarfield.light().light === 'my_studio.exr'")
        self.assertTrue(os.path.exists(os.path.join(self.server.output, "lights", "my_studio.exr")))
        self.page.settle()
        self.assert_bakes_alike("dropped")
        self.page.wait_exact(self.page.send("undo"))
        self.page.wait("return haarfield.light().light === 'interior.exr'")

    def test_what_is_no_panorama_is_refused(self):
        self.drop("broken.exr", b"no picture")
        notice = self.browser.find_element(By.ID, "notice")
        self.page.wait("return !document.getElementById('notice').hidden")
        self.assertIn("found no image", notice.text)
        self.assertFalse(os.path.exists(os.path.join(self.server.output, "lights", "broken.exr")))

    def test_an_8_bit_panorama_dropped_twice_gets_two_names(self):
        pixels = io.BytesIO()
        Image.new("RGB", (64, 32), (90, 120, 160)).save(pixels, "JPEG")
        for name in ["overcast.jpg", "overcast_2.jpg"]:
            self.drop("overcast.jpg", pixels.getvalue())
            self.page.wait("return haarfield.light().light === arguments[0]", name)
            self.assertIn("8-bit", self.browser.find_element(By.ID, "notice").text)
        for _ in range(2):
            self.page.wait_exact(self.page.send("undo"))
        self.page.wait("return haarfield.light().light === 'interior.exr'")

    def drop(self, name, data):
        self.page.js(
            "const bytes = Uint8Array.from(atob(arguments[1]), (c) => c.charCodeAt(0));"
            "const dataTransfer = new DataTransfer();"
            "dataTransfer.items.add(new File([bytes], arguments[0]));"
            "window.dispatchEvent(new DragEvent('drop', {dataTransfer, cancelable: true}))",
            name, base64.b64encode(data).decode())

    def drag_gizmo(self, axis, by=(40, -25)):
        """Searches for a handle of the gizmo around its centre, and drags it."""
        at = self.page.js(
            "const {stage} = haarfield, {gizmo, canvas, camera} = stage;"
            "stage.dirty = true; stage.draw();"
            "const box = canvas.getBoundingClientRect(), middle = gizmo.object.position.clone().project(camera);"
            "for (let radius = 8; radius < 160; radius += 6)"
            " for (let angle = 0; angle < 6.28; angle += 0.26) {"
            "  const x = Math.round((0.5 + middle.x / 2) * box.width + radius * Math.cos(angle));"
            "  const y = Math.round((0.5 - middle.y / 2) * box.height + radius * Math.sin(angle));"
            "  if (document.elementFromPoint(box.left + x, box.top + y) !== canvas) continue;"
            "  canvas.dispatchEvent(new MouseEvent('mousemove',"
            "   {clientX: box.left + x, clientY: box.top + y, bubbles: true}));"
            "  if (gizmo.axis === arguments[0]) return [x - box.width / 2, y - box.height / 2];"
            " }", axis)
        self.assertIsNotNone(at, "the gizmo has no handle " + axis)
        canvas = self.browser.find_element(By.ID, "canvas")
        ActionChains(self.browser, 20).move_to_element_with_offset(
            canvas, round(at[0]), round(at[1])).click_and_hold().move_by_offset(
                by[0] // 2, by[1] // 2).move_by_offset(by[0] // 2, by[1] // 2).release().perform()

    def ring_direction(self):
        """Returns the drag on the screen, of 48 pixels, that rotates the object about x for the current camera."""
        return self.page.js(
            "const {gizmo, canvas, camera} = haarfield.stage, at = gizmo.object.position;"
            "const eye = camera.position.clone().sub(at), along = at.clone().set(1, 0, 0).cross(eye).normalize();"
            "const from = at.clone().project(camera);"
            "const to = at.clone().addScaledVector(along, 0.01 * eye.length()).project(camera);"
            "const x = (to.x - from.x) * canvas.width, y = (from.y - to.y) * canvas.height;"
            "return [x, y].map((part) => Math.round(48 * part / Math.hypot(x, y)));")

    def click_object(self, name):
        """Selects an object by a click into the picture."""
        at = self.page.js(
            "const {stage} = haarfield, box = stage.canvas.getBoundingClientRect(), {pick} = stage.on;"
            "let found;"
            "stage.on.pick = (id) => (found = id);"
            "try {"
            " const hits = (x, y) => {"
            "  stage.pick({clientX: box.left + x, clientY: box.top + y});"
            "  return found && stage.objects.get(found).userData.name === arguments[0];"
            " };"
            " for (let y = 60; y < box.height - 60; y += 10) for (let x = 20; x < box.width - 20; x += 10)"
            "  if ([-4, 0, 4].every((d) => hits(x + d, y) && hits(x, y + d)))"
            "   return [x - box.width / 2, y - box.height / 2];"
            "} finally { stage.on.pick = pick; }", name)
        self.assertIsNotNone(at, name + " is not in the picture")
        canvas = self.browser.find_element(By.ID, "canvas")
        ActionChains(self.browser).move_to_element_with_offset(
            canvas, round(at[0]), round(at[1])).click().perform()

    def test_a_clicked_object_is_moved_by_its_gizmo_and_undone(self):
        before, colours = self.page.objects(), self.page.colours()
        self.click_object("chair_1")
        self.page.wait("return haarfield.stage.chosen === arguments[0]", before["chair_1"]["id"])
        self.page.js("haarfield.panel.on.tool('translate')")
        self.drag_gizmo("X", (30, 0))
        self.page.wait("const {position} = haarfield.stage.objects.get(arguments[0]);"
                       "return Math.abs(position.x) > 0.02", before["chair_1"]["id"])
        self.page.settle()
        self.assert_bakes_alike("moved")
        # One drag is one step of undo.
        self.page.wait_exact(self.page.send("undo"))
        self.assertEqual(self.page.objects(), before)
        self.assert_same(self.page.colours(), colours)

    def test_the_sun_of_a_sky_is_moved(self):
        self.page.send("light", light="sky")
        self.page.wait("return !document.getElementById('sky-fields').hidden")
        self.browser.find_element(By.ID, "sun-elevation").send_keys(Keys.HOME, Keys.ARROW_RIGHT * 20)
        self.page.wait("return haarfield.light().sky?.sun_elevation === 10")
        self.page.settle()
        self.assertEqual(self.page.js("return haarfield.light().light"), "sky")
        self.assert_bakes_alike("low_sun")
        while self.page.js("return haarfield.light().light") != "interior.exr":
            self.page.wait_exact(self.page.send("undo"))

    def test_what_is_cloned_and_deleted_comes_back(self):
        before, colours = self.page.objects(), self.page.colours()
        chair = before["chair_1"]["id"]
        self.page.send("clone", object=chair)
        self.page.wait("return haarfield.stage.objects.size === 4")
        self.assertIn("chair", "".join(self.page.objects().keys() - before.keys()))
        copy = max(each["id"] for each in self.page.objects().values())
        self.page.send("place", object=copy, translate=[-0.8, 0.0, -0.6])
        self.page.wait_exact(self.page.send("delete", object=chair))
        self.assertNotIn("chair_1", self.page.objects())
        self.assert_bakes_alike("cloned")
        for _ in range(3):
            self.page.wait_exact(self.page.send("undo"))
        self.assertEqual(self.page.objects(), before)
        self.assert_same(self.page.colours(), colours)
        self.page.send("redo")
        self.page.wait("return haarfield.stage.objects.size === 4")
        self.page.wait_exact(self.page.send("undo"))

    def test_an_object_deleted_and_restored_at_once_is_visible(self):
        chair = self.page.objects()["chair_1"]["id"]
        self.page.send("delete", object=chair)
        self.page.wait("return !haarfield.stage.objects.has(arguments[0])", chair)
        self.page.wait_exact(self.page.send("undo"))
        self.page.wait("return haarfield.stage.objects.get(arguments[0])?.children.length === 1", chair)

    def test_objects_are_chosen_and_moved_by_keys(self):
        before, eye = self.page.objects(), self.eye()
        canvas = self.browser.find_element(By.ID, "canvas")
        self.page.js("haarfield.panel.on.choose(null)")
        canvas.send_keys("n")
        chosen = self.page.js("return haarfield.stage.objects.get(haarfield.stage.chosen).userData.name")
        canvas.send_keys("w", Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.PAGE_UP)
        step = self.page.js("return haarfield.stage.keyStep()")
        self.page.settle()
        moved = [b - a for a, b in zip(before[chosen]["position"], self.page.objects()[chosen]["position"])]
        self.assertAlmostEqual(moved[1], step, 5)
        self.assertAlmostEqual(math.hypot(moved[0], moved[2]), 2 * step, 5)
        canvas.send_keys("e", Keys.ARROW_LEFT)
        self.page.settle()
        self.assertAlmostEqual(abs(self.page.objects()[chosen]["rotation"][1]), math.sin(math.radians(2.5)), 4)
        canvas.send_keys("r", Keys.ARROW_UP)
        self.page.settle()
        self.assertAlmostEqual(self.page.objects()[chosen]["scale"], 1.05, 4)
        self.assertEqual(self.eye(), eye)
        for _ in range(5):  # a step for each key
            self.page.wait_exact(self.page.send("undo"))
        self.assertEqual(self.page.objects(), before)

    def test_the_keys_are_listed(self):
        self.browser.find_element(By.ID, "canvas").send_keys("?")
        listed = self.page.wait("const list = document.getElementById('keys'); return list.open && list.innerText")
        for key in ["Ctrl Shift Z", "Page Up", "Esc", "Del"]:
            self.assertIn(key, listed)
        self.page.js("document.getElementById('keys').close()")

    def test_the_status_counts_objects_that_have_not_arrived(self):
        status = "const pill = document.getElementById('exactness'); return [pill.textContent, pill.className];"
        text, kind = self.page.js(status)
        self.assertRegex(text, r"(exact at vertices|error [\d.]+ %) · [\d,]+ vertices")
        self.assertEqual(kind, "pill exact")
        shown = self.page.js(
            "const {stage} = haarfield, chair = [...stage.objects.values()].at(-1), mesh = chair.children[0];"
            "chair.remove(mesh); haarfield.connection.on.frame({...haarfield.stats.last, objects: new Map()});"
            "try { " + status + " } finally { chair.add(mesh); }")
        self.assertEqual(shown, ["loading 1 of 3 objects", "pill moving"])
        self.page.wait_exact(self.page.send("select", object=None))

    def test_materials_change_in_the_panel(self):
        self.page.js("document.getElementById('material').value = 'parquet'; haarfield.panel.showMaterial()")
        field = self.browser.find_element(By.CSS_SELECTOR, "[data-key='finish.diffuse']")
        field.send_keys(Keys.HOME)
        self.page.settle()
        self.page.wait("return haarfield.panel.materials.parquet.finish.diffuse === 0")
        self.assert_bakes_alike("dark_floor")
        self.page.wait_exact(self.page.send("undo"))

    def test_two_lights_are_mixed_and_exposed(self):
        self.page.send("light", light="interior.exr", second="sunset.exr", share=0.25)
        self.page.send("exposure", stops=-1.5)
        self.page.wait_exact(self.page.send("mix", share=0.6))
        self.assert_bakes_alike("mixed")
        for _ in range(3):
            self.page.wait_exact(self.page.send("undo"))

    def test_highlights_follow_the_eye(self):
        before = self.page.colours()
        canvas = self.browser.find_element(By.ID, "canvas")
        ActionChains(self.browser, 20).move_to_element_with_offset(canvas, -60, -40).click_and_hold(
        ).move_by_offset(60, 10).release().perform()
        self.page.settle()
        self.assertGreater(view.relative_difference(self.page.colours()["floor"], before["floor"]), 0.003)
        self.assert_bakes_alike("looked")

    def eye(self):
        return self.page.js("const {camera, orbit} = haarfield.stage;"
                            "return [...camera.position.toArray(), ...orbit.target.toArray()]")

    def test_looking_round_is_taken_back(self):
        colours, eyes = self.page.colours(), [self.eye()]
        canvas = self.browser.find_element(By.ID, "canvas")
        for x, y in [(60, 10), (-30, 25)]:  # two at once
            ActionChains(self.browser, 20).move_to_element_with_offset(canvas, -60, -40).click_and_hold(
            ).move_by_offset(x, y).move_by_offset(x, 0).release().perform()
            eyes.append(self.eye())
        self.page.js("for (let i = 0; i < 4; ++i)"  # one gesture
                     " haarfield.stage.canvas.dispatchEvent(new WheelEvent('wheel', {deltaY: 100, cancelable: true}))")
        eyes.append(self.eye())
        self.page.settle()
        for before, after in zip(eyes, eyes[1:]):
            self.assertGreater(math.dist(before, after), 0.05)
        for place in reversed(eyes[:-1]):
            self.page.js("document.getElementById('undo').click()")
            self.page.settle()
            self.assertLess(math.dist(self.eye(), place), 1e-4)
        self.assert_same(self.page.colours(), colours)
        self.page.js("document.getElementById('redo').click()")
        self.page.settle()
        self.assertLess(math.dist(self.eye(), eyes[1]), 1e-4)
        self.page.js("document.getElementById('undo').click()")
        self.page.settle()

    def test_saves_the_scene_so_that_it_opens_alike(self):
        chair = self.page.objects()["chair_2"]["id"]
        self.page.send("place", object=chair, translate=[0.7, 0.1, -0.3], scale=1.2,
                       rotation=[0.1, 0.2, 0.0, 0.9])
        scene = self.assert_bakes_alike("saved")
        with open(scene) as file:
            self.assertTrue(file.read().startswith("# Kept when the scene is saved."))
        other = view.Server(scene)
        try:
            self.browser.switch_to.new_window("tab")
            page = view.Page(self.browser, other.url)
            page.wait_exact()
            self.assert_same(page.colours(), self.in_first_window(self.page.colours))
        finally:
            self.close_second_window()
            other.stop()
        self.page.wait_exact(self.page.send("undo"))

    def test_comments_in_the_scenes_file_are_not_lost(self):
        with open(self.server.scene, "a") as file:
            file.write("# The second one stands free.\n")
        with open(self.server.scene) as file:
            text = file.read()
        self.browser.find_element(By.ID, "save").click()
        beside = os.path.join(self.server.folder, "room.view.toml")
        self.page.wait("return haarfield.stats.saved === arguments[0]", beside)
        notice = self.browser.find_element(By.ID, "notice").text
        self.assertIn("room.view.toml", notice)
        self.assertIn("comments", notice)
        with open(self.server.scene) as file:
            self.assertEqual(file.read(), text)
        self.assertEqual(set(view.instance_names(beside)), self.page.objects().keys())

    def in_first_window(self, do):
        here = self.browser.current_window_handle
        self.browser.switch_to.window(self.page.window)
        result = do()
        self.browser.switch_to.window(here)
        return result

    def close_second_window(self):
        if self.browser.current_window_handle != self.page.window:
            self.browser.close()
            self.browser.switch_to.window(self.page.window)

    def test_a_second_page_watches_until_it_takes_over(self):
        chair = self.page.objects()["chair_1"]["id"]
        self.browser.switch_to.new_window("tab")
        try:
            second = view.Page(self.browser, self.server.url)
            self.assertFalse(second.js("return haarfield.isSteering()"))
            # A window in the background draws nothing, and must not delay other pages.
            number = self.in_first_window(
                lambda: self.page.send("place", object=chair, translate=[0.1, 0.2, 0.3]))
            second.wait("return haarfield.stage.objects.get(arguments[0]).position.y > 0.19", chair)
            second.wait_exact(number)
            second.js("haarfield.connection.send('place', {object: arguments[0], translate: [0, 0, 0]})", chair)
            second.wait("return haarfield.stats.errors.some(({message}) => message.includes('steers'))")
            second.js("document.getElementById('steer').click()")
            second.wait("return haarfield.isSteering()")
            self.assertFalse(self.in_first_window(lambda: self.page.wait("return true") and
                                                  self.page.js("return haarfield.isSteering()")))
            second.wait_exact(second.send("undo"))
        finally:
            self.close_second_window()
        # The remaining page steers again.
        self.page.wait("return haarfield.isSteering()")

    def test_a_lost_connection_is_taken_up_again(self):
        before = self.page.objects()
        self.page.js("haarfield.connection.socket.close()")
        self.page.wait("return !document.getElementById('lost').hidden")
        self.page.wait("return document.getElementById('lost').hidden && haarfield.isSteering()")
        self.page.wait_exact()
        self.assertEqual(self.page.objects(), before)

    def test_hundred_random_gestures_end_where_a_fresh_bake_does(self):
        chance = random.Random(19)
        objects = [each["id"] for each in self.page.objects().values()]
        chairs = [each["id"] for name, each in self.page.objects().items() if "chair" in name]
        start = self.page.js("return haarfield.stats.frames")
        gesture = 1000
        for _ in range(100):
            gesture += 1
            kind = chance.choice(["light", "light", "move", "move", "turn", "scale", "look", "exposure", "undo",
                                  "redo", "material", "select", "clone", "exchange"])
            chair = chance.choice(chairs)
            spread = lambda size: chance.uniform(-size, size)
            if kind == "light":
                for _ in range(3):
                    self.page.send("turn_light", gesture=gesture, rotation=[spread(1) for _ in range(4)])
            elif kind == "move":
                for _ in range(3):
                    self.page.send("place", gesture=gesture, object=chair,
                                   translate=[spread(1), chance.uniform(0, 0.5), spread(1)])
            elif kind == "turn":
                self.page.send("place", gesture=gesture, object=chair, rotation=[0, spread(1), 0, 1])
            elif kind == "scale":
                self.page.send("place", gesture=gesture, object=chair, scale=chance.uniform(0.5, 1.5))
            elif kind == "look":
                for _ in range(3):
                    self.page.send("look", position=[spread(2), chance.uniform(0.5, 2), spread(2)],
                                   target=[0, 0.4, 0], vertical_fov=40, width=640, height=480)
            elif kind == "exposure":
                self.page.send("exposure", stops=chance.choice(["auto", spread(2)]))
            elif kind == "material":
                self.page.send("material", name="walnut", diffuse=[chance.random() for _ in range(3)],
                               specular=[0.3, 0.3, 0.3], shininess=chance.uniform(5, 100), convention="povray")
            elif kind == "clone":
                self.page.send(chance.choice(["clone", "delete"]), object=chair)
            elif kind == "exchange":
                self.page.send("light", light=chance.choice(["interior.exr", "sunset.exr", "studio.exr"]))
            else:
                content = {"object": chair} if kind == "select" else {}
                self.page.send(kind, **content)
            time.sleep(chance.choice([0, 0, 0.02, 0.3]))
        number = self.page.send("exposure", stops=0.5)
        self.page.wait_exact(number)
        self.assertGreater(self.page.js("return haarfield.stats.frames") - start, 10)
        self.assertTrue(set(objects) - set(chairs) <= {each["id"] for each in self.page.objects().values()})
        self.assert_bakes_alike("random")
        while not self.page.js("return document.getElementById('undo').disabled"):
            self.page.send("undo")
            time.sleep(0.02)
        self.page.wait_exact(self.page.send("select", object=None))

    def test_a_screenshot_is_the_preview_renderers_picture(self):
        self.page.js("document.body.style.gridTemplateColumns = '1fr';"
                     "document.getElementById('panel').hidden = true;"
                     "Object.assign(document.getElementById('stage').style, {width: '640px', height: '480px'})")
        try:
            self.page.wait("return haarfield.stage.camera.aspect === 640 / 480 && haarfield.stage.dirty === false")
            self.page.wait_exact()
            shot = os.path.join(self.server.folder, "shot.png")
            with open(shot, "wb") as file:
                file.write(self.page.canvas_png())
            done = self.page.task("picture")
            self.assertEqual(done["files"], ["room_view.png", "room_view.exr"])
            # The picture of the task has the size of the scene's camera, which is smaller.
            small = os.path.join(self.server.folder, "small.png")
            with Image.open(shot) as image:
                self.assertEqual(image.size, (640, 480))
                image.convert("RGB").resize((160, 120), Image.BOX).save(small)
            compared = subprocess.run(
                [view.PROGRAM, "compare", small, os.path.join(self.server.output, "picture", "room_view.png"),
                 "-o", os.path.join(self.server.folder, "compared"), "--min-psnr", "30"],
                stdout=subprocess.PIPE, text=True)
            self.assertEqual(compared.returncode, 0, compared.stdout)
        finally:
            self.page.js("document.body.style.gridTemplateColumns = '';"
                         "document.getElementById('panel').hidden = false;"
                         "Object.assign(document.getElementById('stage').style, {width: '', height: ''})")

    def test_bake_ends_with_files(self):
        done = self.page.task("bake", patience=300)
        self.assertEqual(done["state"], "done", done)
        for name in ["baked.png", "room.pov", "room.ply"]:
            self.assertIn(name, done["files"])
        length = self.page.js(
            "const done = arguments[0];"
            "fetch('made/baked.png').then((r) => r.arrayBuffer()).then((b) => window.madeLength = b.byteLength)")
        length = self.page.wait("return window.madeLength")
        self.assertEqual(length, os.path.getsize(os.path.join(self.server.output, "bake", "baked.png")))

    def test_a_page_of_another_origin_gets_nothing(self):
        class Stranger(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(b"<!doctype html><title>stranger</title>")

            def log_message(self, *_):
                pass

        stranger = http.server.HTTPServer(("127.0.0.1", 0), Stranger)
        threading.Thread(target=stranger.serve_forever, daemon=True).start()
        self.browser.switch_to.new_window("tab")
        try:
            self.browser.get(f"http://127.0.0.1:{stranger.server_port}/")
            got = self.browser.execute_async_script(
                "const [url, done] = arguments, got = [];"
                "const tries = [fetch(url), fetch(url + 'mesh/0', {mode: 'no-cors'}),"
                " fetch(url + 'lights/x.exr', {method: 'POST', body: 'x'})];"
                "const socket = new WebSocket(url.replace('http', 'ws') + 'session');"
                "tries.push(new Promise((resolve, reject) => {"
                " socket.onopen = resolve; socket.onerror = () => reject(); }));"
                "Promise.allSettled(tries).then((all) => done(all.map(({status, value}) =>"
                " status === 'fulfilled' ? (value.type ?? 'open') : 'refused')))", self.server.url)
            self.assertEqual(got, ["refused"] * 4)
        finally:
            self.close_second_window()
            stranger.shutdown()
            stranger.server_close()


class OwnServerTest(unittest.TestCase):
    """Tests with a separate server and browser each."""

    def opened(self, *options):
        scratch = view.scratch()
        self.addCleanup(scratch.__exit__, None, None, None)
        return self.opened_scene(view.write_scene(scratch.__enter__(), resolution=[48, 36]), *options)

    def opened_scene(self, scene, *options):
        browser = view.started_browser()
        self.addCleanup(browser.quit)
        server = view.Server(scene, *options)
        self.addCleanup(server.stop)
        return server, browser, view.Page(browser, server.url)

    def test_lamps_and_model_materials_are_edited(self):
        scratch = view.scratch()
        self.addCleanup(scratch.__exit__, None, None, None)
        scene = view.write_scene(scratch.__enter__(), resolution=[48, 36])
        with open(scene) as file:
            text = file.read()
        with open(scene, "w") as file:
            file.write(text.replace('material = "walnut"\n', "") + LAMP)
        server, browser, page = self.opened_scene(scene)
        self.assertEqual(page.js("return document.getElementById('lamp').value"), "bulb")
        browser.find_element(By.ID, "lamp-strength").send_keys(Keys.END)
        page.wait("return haarfield.panel.lamp().colour[0] > 30")
        page.settle()
        bright = page.colours()["floor"].mean()
        browser.find_element(By.ID, "lamp-strength").send_keys(Keys.HOME)
        page.settle()
        self.assertLess(page.colours()["floor"].mean(), 0.9 * bright)
        chair = page.objects()["chair_1"]["id"]
        page.js("haarfield.panel.on.choose(arguments[0], null, 0)", chair)
        browser.find_element(By.ID, "own").click()
        page.wait("return haarfield.stage.materialOf(arguments[0], 0) !== null", chair)
        page.wait("return document.getElementById('own-row').hidden")
        before = page.colours()["chair_1"]
        browser.find_element(By.CSS_SELECTOR, "[data-key='finish.emission'], [data-key='emission.strength']").send_keys(Keys.ARROW_RIGHT * 50)
        page.settle()
        self.assertGreater(page.colours()["chair_1"].mean(), before.mean() + 0.5)

    def test_unsaved_changes_are_offered_at_the_next_start(self):
        server, browser, page = self.opened()
        chair = page.objects()["chair_1"]["id"]
        page.wait_exact(page.send("place", object=chair, translate=[0.3, 0.1, 0.2]))
        moved = page.objects()
        autosaved = os.path.join(server.folder, "room.autosave.toml")
        deadline = time.monotonic() + view.PATIENCE
        while not os.path.exists(autosaved):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.1)
        server.process.kill()
        again = view.Server(server.scene)
        self.addCleanup(again.stop)
        page = view.Page(browser, again.url)
        page.wait("return document.getElementById('autosave').open")
        self.assertIn("room.autosave.toml", browser.find_element(By.ID, "autosave").text)
        browser.find_element(By.ID, "restore").click()
        page.wait("return !document.getElementById('autosave').open")
        page.settle()
        place = lambda objects: {name: (each["position"], each["rotation"]) for name, each in objects.items()}
        self.assertEqual(place(page.objects()), place(moved))
        # After saving, nothing is offered.
        browser.find_element(By.ID, "save").click()
        page.wait("return haarfield.stats.saved")
        self.assertFalse(os.path.exists(autosaved))

    def test_the_page_stops_trying_to_reach_a_server_that_has_ended(self):
        server, browser, page = self.opened()
        page.js("haarfield.connection.patience = 2")
        self.assertEqual(server.stop(), 0)
        page.wait("return !document.getElementById('lost').hidden")
        page.wait("return document.getElementById('lost-text').textContent.includes('has ended')")
        page.js("window.lastSocket = haarfield.connection.socket")
        time.sleep(2.5)
        self.assertTrue(page.js("return window.lastSocket === haarfield.connection.socket"))
        browser.find_element(By.ID, "reconnect").click()
        page.wait("return window.lastSocket !== haarfield.connection.socket")

    def compare(self, *options):
        """Makes the reference. Returns its bounces, whether its scene has indirect light, and the page's text."""
        server, browser, page = self.opened(*options)
        done = page.task("reference", patience=300)
        self.assertEqual(done["state"], "done", done)
        page.wait("return !document.getElementById('compare').hidden &&"
                  " document.getElementById('compare-image').naturalWidth === 48")
        with open(os.path.join(server.output, "reference", "room_reference.pov")) as file:
            has_indirect = "Indirect light of the light sources" in file.read()
        said = [browser.find_element(By.ID, side + "-light").text for side in ("reference", "view")]
        self.assert_compares_one_view(browser, page)
        return done["bounces"], has_indirect, said

    def assert_compares_one_view(self, browser, page):
        """The labels of a comparison are below the toolbar. It ends when the view changes; its button restores both."""
        label, tools = (browser.find_element(By.ID, id).rect for id in ("reference-light", "tools"))
        self.assertGreaterEqual(label["y"], tools["y"] + tools["height"])
        browser.find_element(By.ID, "canvas").send_keys(Keys.SHIFT, Keys.ARROW_RIGHT)
        page.wait("return document.getElementById('compare').hidden")
        browser.find_element(By.ID, "compare-button").click()
        page.wait("return !document.getElementById('compare').hidden &&"
                  " haarfield.stage.isAt(haarfield.panel.reference.view)")
        page.send("exposure", stops=1)
        page.wait("return document.getElementById('reference-light').textContent.includes('earlier state')")

    def test_bounces_are_compared_with_a_bounce(self):
        bounces, has_indirect, said = self.compare()
        self.assertEqual(bounces, 1)
        self.assertTrue(has_indirect)
        self.assertEqual(said, ["reference: direct light and one bounce",
                                "this view: all significant bounces of light"])

    def test_what_has_no_bounces_is_compared_with_what_has_none(self):
        bounces, has_indirect, said = self.compare("--bounces", "0")
        self.assertEqual(bounces, 0)
        self.assertFalse(has_indirect)
        self.assertEqual(said, ["reference: direct light alone", "this view: direct light alone"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
