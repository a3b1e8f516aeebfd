"""Operators that bake, export for POV-Ray, display bakes and compare with Cycles."""

import threading
import warnings
from pathlib import Path

import bpy

import haarfield

from . import cycles_check, results
from .gather import gather
from .shaders import Refusal


class Memory:
    """The last bake of a scene, so that only changes are baked again."""

    def __init__(self, scene, digests, bake):
        self.scene, self.digests, self.bake = scene, digests, bake


remembered = {}  # by the name of Blender's scene


class Cancelled(Exception):
    pass


class Work(threading.Thread):
    """A bake in a separate thread, while Blender continues."""

    def __init__(self, gathered, target, fields, memory, passes=()):
        super().__init__(daemon=True)
        self.gathered, self.fields, self.memory, self.passes = gathered, fields, memory, list(passes)
        self.target = max(target, 0.01) / 100 if target > 0 else "off"
        self.stage, self.share = "", 0.0
        self.is_cancelled = False
        self.made, self.error, self.told = None, None, []

    def progress(self, stage, done, total):
        if self.is_cancelled:
            raise Cancelled
        self.stage, self.share = stage, done / max(1, total)

    def run(self):
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                self.made = self.baked()
            self.told = [str(warning.message) for warning in caught]
        except Exception as error:
            self.error = error

    def scene(self):
        """Returns the scene. Reuses meshes and fields if only light and camera have changed."""
        description = self.gathered.description
        kept = {"light", "camera"}
        before = self.memory.digests if self.memory else {}
        same = {key: value for key, value in before.items() if key not in kept} == {
            key: value for key, value in self.gathered.digests.items() if key not in kept
        }
        if self.memory and same:
            light = {"rotation": 0.0, **description["environment"]}
            changes = {"camera": description["camera"], "environment": light, "lights": description["lights"]}
            return self.memory.scene.changed(changes)
        scene = haarfield.scene(description, name="blender")
        if self.target == "off":
            scene.prepare(fields=self.fields, progress=self.progress)
        return scene

    def baked(self):
        scene = self.scene()
        return scene, scene.bake(
            error=self.target, everywhere=self.target != "off", passes=self.passes, progress=self.progress
        )


def folder_of(scene):
    """Returns the folder of the settings. For a scene without a file, Blender deletes the folder when it ends."""
    chosen = scene.haarfield.folder
    if chosen.startswith("//") and not bpy.data.filepath:
        return Path(bpy.app.tempdir) / "haarfield"
    return Path(bpy.path.abspath(chosen))


def changes_of(gathered, memory):
    """Returns the names of everything that has changed since the last bake."""
    before = memory.digests if memory else {}
    return {name for name, digest in gathered.digests.items() if before.get(name) != digest} | (
        set(before) - set(gathered.digests)
    )


class Baking:
    """Shared parts of the operators."""

    def start(self, context, error=None):
        """Gathers the scene. Returns the bake to run, or None if nothing has changed since the last bake.

        error  overrides the settings.
        """
        error = context.scene.haarfield.error if error is None else error
        scene = context.scene
        self.was_shown = results.is_shown(scene)
        results.show(scene, context.view_layer, False)
        context.view_layer.update()
        self.gathered = gather(context, error)
        for warning in self.gathered.warnings:
            self.report({"WARNING"}, warning)
        self.memory = remembered.get(scene.name)
        self.changes = changes_of(self.gathered, self.memory)
        if not self.changes and set(results.copies(scene)) == set(self.gathered.names):
            return None
        return Work(self.gathered, error, folder_of(scene) / "fields", self.memory)

    def take(self, context, work):
        """Stores and displays the results of a bake."""
        if isinstance(work.error, Cancelled):
            self.report({"WARNING"}, "Cancelled; nothing was changed")
            results.show(context.scene, context.view_layer, self.was_shown)
            return False
        if work.error is not None:
            raise work.error
        for warning in work.told:
            self.report({"WARNING"}, warning)
        made, bake = work.made
        remembered[context.scene.name] = Memory(made, self.gathered.digests, bake)
        everything = "settings" in self.changes
        anew = set(self.gathered.names) if everything else self.changes & set(self.gathered.names)
        results.write(context.scene, context.view_layer, bake, self.gathered, anew)
        what = "everything" if self.memory is None else ", ".join(sorted(self.changes))
        error = f", error {100 * bake.error['reached']:.1f} %" if bake.error else ""
        self.report({"INFO"}, f"Baked {bake.vertices} vertices in {bake.seconds:.2f} s{error}; changed: {what}")
        if bake.error and not bake.error["is_met"]:
            self.report({"WARNING"}, f"The error is above {100 * bake.error['target']:.2g} %: {bake.error['reason']}")
        return True

    def guarded(self, context, act):
        """Reports errors as messages in Blender, without changes to the scene."""
        try:
            return act()
        except (Refusal, haarfield.Error, OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            results.show(context.scene, context.view_layer, self.was_shown)
            return {"CANCELLED"}


class HAARFIELD_OT_bake(Baking, bpy.types.Operator):
    """Bake light into a colour attribute of each object"""

    bl_idname = "haarfield.bake"
    bl_label = "Bake with haarfield"
    bl_options = {"REGISTER"}

    export: bpy.props.BoolProperty(name="Export", description="Also write a POV-Ray scene", default=False)

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        return self.guarded(context, lambda: self.done(context, self.finished(self.start(context))))

    def invoke(self, context, event):
        def begin():
            self.work = self.start(context)
            if self.work is None:
                return self.done(context, None)
            self.work.start()
            manager = context.window_manager
            manager.progress_begin(0, 1000)
            self.timer = manager.event_timer_add(0.1, window=context.window)
            manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}

        return self.guarded(context, begin)

    def modal(self, context, event):
        if event.type == "ESC":
            self.work.is_cancelled = True
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type != "ESC" else {"RUNNING_MODAL"}
        manager = context.window_manager
        manager.progress_update(int(1000 * self.work.share))
        context.workspace.status_text_set(f"haarfield: {self.work.stage}, {100 * self.work.share:.0f} %   ESC: cancel")
        if self.work.is_alive():
            return {"RUNNING_MODAL"}
        manager.event_timer_remove(self.timer)
        manager.progress_end()
        context.workspace.status_text_set(None)
        return self.guarded(context, lambda: self.done(context, self.work))

    @staticmethod
    def finished(work):
        if work is not None:
            work.run()
        return work

    def done(self, context, work):
        if work is None:
            results.show(context.scene, context.view_layer, True)
            self.report({"INFO"}, "Nothing has changed since the last bake")
        elif not self.take(context, work):
            return {"CANCELLED"}
        if self.export:
            folder = folder_of(context.scene)
            name = Path(bpy.data.filepath).stem or "blender"
            files = remembered[context.scene.name].bake.write_povray(folder, name)
            self.report({"INFO"}, f"Wrote {files['scene']}")
        return {"FINISHED"}


class HAARFIELD_OT_show(bpy.types.Operator):
    """Show the baked copies or the original objects"""

    bl_idname = "haarfield.show"
    bl_label = "Show Baked"
    bl_options = {"REGISTER", "UNDO"}

    baked: bpy.props.BoolProperty(name="Baked", default=True)

    @classmethod
    def poll(cls, context):
        return bool(results.copies(context.scene))

    def execute(self, context):
        results.show(context.scene, context.view_layer, self.baked)
        return {"FINISHED"}


class HAARFIELD_OT_compare(Baking, bpy.types.Operator):
    """Bake direct diffuse light at the same vertices with Cycles, and write a table of errors and times"""

    bl_idname = "haarfield.compare"
    bl_label = "Compare with Cycles"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        return self.guarded(context, lambda: self.compared(context))

    def compared(self, context):
        # Both programs bake the vertices of the meshes as they are.
        work = self.start(context, error=0.0)
        if work is not None:
            work.run()
            self.take(context, work)
        results.show(context.scene, context.view_layer, True)
        memory = remembered[context.scene.name]
        diffuse, sums = (
            memory.scene.bake(error="off", passes=["diffuse"], bounces=0, evaluator=evaluator)
            for evaluator in ("tree", "dense")
        )
        rows = cycles_check.compared(context, diffuse, sums, self.gathered)
        name = cycles_check.write_table(context.scene, rows, memory.bake.seconds)
        self.report({"INFO"}, f"Text '{name}' has the comparison")
        return {"FINISHED"}


CLASSES = (HAARFIELD_OT_bake, HAARFIELD_OT_show, HAARFIELD_OT_compare)


@bpy.app.handlers.persistent
def forget(_):
    remembered.clear()


def register():
    for made in CLASSES:
        bpy.utils.register_class(made)
    bpy.app.handlers.load_post.append(forget)


def unregister():
    bpy.app.handlers.load_post.remove(forget)
    for made in reversed(CLASSES):
        bpy.utils.unregister_class(made)
    remembered.clear()
