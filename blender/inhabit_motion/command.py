"""The command in a process of its own, with files in a folder that is gone afterwards."""

import json
import os
import subprocess
import tempfile


class Refused(Exception):
    """One line that says what was wrong."""


class Run:
    """`command verb ...` on its way; files that it reads and writes lie in `folder`."""

    def __init__(self):
        self.files = tempfile.TemporaryDirectory(prefix="inhabit_motion_")
        self.folder = self.files.name
        self.process = None
        self.warnings = []  # what the command said of a result that it gave all the same

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, clip):
        with open(self.path(name), "w", encoding="utf-8") as file:
            json.dump(clip, file)
        return self.path(name)

    def start(self, command, arguments):
        try:
            self.process = subprocess.Popen([command, *arguments, "-o", self.path("out.json"), "--quiet"], stdin=subprocess.DEVNULL,
                                            stdout=subprocess.DEVNULL, stderr=open(self.path("errors.txt"), "wb"))
        except OSError as error:
            self.end()
            raise Refused(f"{command}: {error.strerror}; the add-on's preferences say where the command is") from None

    def result(self):
        """The clip that was written, once the process has ended."""
        try:
            code = self.process.wait()
            with open(self.path("errors.txt"), encoding="utf-8", errors="replace") as file:
                lines = [line.removeprefix("inhabit: ").replace(self.folder + os.sep, "") for line in file.read().strip().splitlines()]
            if code != 0:
                raise Refused(lines[-1] if lines else "the command failed")
            self.warnings = [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]
            with open(self.path("out.json"), encoding="utf-8") as file:
                return json.load(file)
        finally:
            self.end()

    def end(self):
        if self.process and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.files.cleanup()
