"""What the panel's buttons do: the armature's motion goes to the command, what comes back is a new action."""

import bpy

from . import armature, scene_file
from .command import Refused, Run
from .preferences import command_of


def rig_of(context):
    rigs = [o for o in [context.active_object, *context.selected_objects] if o and o.type == "ARMATURE"]
    return rigs[0] if rigs else None


class MotionOperator:
    """Prepares a run, waits for it (in the interface without holding it up; escape ends it), and makes an action of it."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return rig_of(context) is not None

    def motion(self, context, run):
        """Arguments of the command; sets self.first, the frame at which its result begins."""
        raise NotImplementedError

    def action_of(self, clip):
        """The clip of the new action, of what the command wrote."""
        return clip

    def scene_arguments(self, context, run, needed=False):
        meshes = [o for o in context.selected_objects if o.type == "MESH" and o.find_armature() is None]
        if context.scene.inhabit.chair and needed and context.scene.inhabit.chair not in meshes:
            meshes.append(context.scene.inhabit.chair)
        if not meshes:
            if needed:
                raise Refused("select the chair, and what else is in the room, beside the armature")
            return []
        scene_file.write_scene(context, meshes, run.path("scene.obj"))
        return ["--scene", run.path("scene.obj"), "--scene-up", "y", "--scene-scale", "1"]

    def begin(self, context):
        self.rig = rig_of(context)
        if len(self.rig.data.bones) == 0:
            raise Refused(f"{self.rig.name} has no bones")
        self.run = Run()
        try:
            arguments = self.motion(context, self.run)
        except Refused:
            self.run.end()
            raise
        self.run.start(command_of(context), arguments)

    def finish(self):
        clip = self.action_of(self.run.result())
        before = self.rig.animation_data.action if self.rig.animation_data else None
        base = before.name if before else self.rig.name
        armature.new_action(self.rig, clip, self.first, f"{base} {self.suffix}")
        self.report({"INFO"}, f"{len(clip['trans'])} frames from frame {self.first} on")
        for warning in self.run.warnings:  # last, for the status bar shows what was said last
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def refuse(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def execute(self, context):
        try:
            self.begin(context)
            return self.finish()
        except Refused as error:
            return self.refuse(error)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self.begin(context)
        except Refused as error:
            return self.refuse(error)
        self.timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        running = self.run.process.poll() is None
        if event.type == "ESC" and running:
            context.window_manager.event_timer_remove(self.timer)
            self.run.end()
            return {"CANCELLED"}
        if running or event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        try:
            return self.finish()
        except Refused as error:
            return self.refuse(error)


class InhabitInbetween(MotionOperator, bpy.types.Operator):
    """The motion between the keys of the action, in the selected meshes"""

    bl_idname = "inhabit.inbetween"
    bl_label = "In-between keys"
    suffix = "in-between"

    def motion(self, context, run):
        keys = armature.keyed_frames(self.rig)
        if len(keys) < 2:
            raise Refused(f"{self.rig.name} needs an action with keys of its bones in two frames or more")
        self.first = keys[0]
        clip = armature.clip_of(context, self.rig, range(keys[0], keys[-1] + 1))
        return ["inbetween", run.write("keys.json", clip), "--keyframes", ",".join(str(k - keys[0]) for k in keys),
                "--seed", str(context.scene.inhabit.seed), *self.scene_arguments(context, run)]


class InhabitForecast(MotionOperator, bpy.types.Operator):
    """The next two seconds from the play head on, after the motion before it"""

    bl_idname = "inhabit.forecast"
    bl_label = "Forecast from the play head"
    suffix = "forecast"

    def motion(self, context, run):
        now = context.scene.frame_current
        keys = armature.keyed_frames(self.rig)
        self.first = min([k for k in keys if k <= now], default=now)
        self.before = armature.clip_of(context, self.rig, range(self.first, now + 1))
        return ["forecast", run.write("observed.json", self.before), *self.scene_arguments(context, run)]

    def action_of(self, clip):
        return armature.joined(self.before, clip)


class InhabitClean(MotionOperator, bpy.types.Operator):
    """The action's motion without noise, its feet in place, nobody inside the selected meshes"""

    bl_idname = "inhabit.clean"
    bl_label = "Clean"
    suffix = "clean"

    def motion(self, context, run):
        keys = armature.keyed_frames(self.rig)
        if len(keys) < 2:
            raise Refused(f"{self.rig.name} needs an action with keys of its bones in two frames or more")
        self.first = keys[0]
        clip = armature.clip_of(context, self.rig, range(keys[0], keys[-1] + 1))
        return ["refine", run.write("motion.json", clip), "--smooth", str(context.scene.inhabit.smooth),
                *self.scene_arguments(context, run)]


class InhabitSit(MotionOperator, bpy.types.Operator):
    """Goes from the pose at the play head to the chair and sits down, the hands at the empties"""

    bl_idname = "inhabit.sit"
    bl_label = "Sit on the chair"
    suffix = "sit"

    def motion(self, context, run):
        settings = context.scene.inhabit
        self.first = context.scene.frame_current + 1
        arguments = ["interact", run.write("start.json", armature.clip_of(context, self.rig, [context.scene.frame_current])),
                     *self.scene_arguments(context, run, needed=True), "--seconds", "%g" % settings.seconds]
        if settings.chair:
            arguments += ["--chair", scene_file.file_name(settings.chair)]
        for side, empty in (("--left", settings.left), ("--right", settings.right)):
            if empty:
                arguments += [side, "%.4f,%.4f,%.4f" % tuple(armature.y_up(empty.matrix_world.translation))]
        if settings.hold:
            arguments += ["--hold", "end"]
        return arguments


CLASSES = (InhabitInbetween, InhabitForecast, InhabitClean, InhabitSit)
