"""`inhabit stream` as a child process: joints of people in, what they will do next out. Needs nothing but Python."""
import json
import math
import subprocess
import threading


class InhabitStream:
    """Starts the command; `told(answer)` is called on a thread of its own with each line that it says, a dict
    (docs/robots.md): {"time", "person", "rate", "joints" or "futures"}, {"error", ...} or, first, {"ready", "names", ...}.
    """

    def __init__(self, told, system="forecast", arguments=(), command="inhabit"):
        self.child = subprocess.Popen([command, "stream", system, *arguments], stdin=subprocess.PIPE,
                                      stdout=subprocess.PIPE, text=True, bufsize=1)
        self.lock = threading.Lock()
        self.reader = threading.Thread(target=self._read, args=(told,), daemon=True)
        self.reader.start()

    def _read(self, told):
        for line in self.child.stdout:
            told(json.loads(line))

    def push(self, person, time, joints):
        """A person's joints, a list of (x, y, z) in metres, at `time` seconds. What is not finite was not seen.
        False where the command has ended."""
        places = [[float(x) if math.isfinite(x) else None for x in joint] for joint in joints]
        line = json.dumps({"time": time, "person": person, "joints": places})
        try:
            with self.lock:
                self.child.stdin.write(line + "\n")
        except (BrokenPipeError, ValueError):
            return False
        return True

    def close(self):
        """Lets the command answer what it was given, and waits for it. Its exit code."""
        try:
            self.child.stdin.close()
        except BrokenPipeError:
            pass
        self.reader.join()
        self.child.stdout.close()
        return self.child.wait()
