# SPDX-License-Identifier: LGPL-2.1-or-later
"""Long work in a thread of its own, watched from the main thread. No window is needed.

The work is a function of progress(stage, fraction), as the library calls it. Whoever owns the
event loop asks poll() now and then; what the work returned or raised stands in the task.
"""

import threading
import time

from . import binding

# Shares of the whole time that stages take, measured on the examples: remaining work is guessed
# from them. Stages come in this order; a stage named later ends all before it.
STAGES = (
    ("shape", 0.01),
    ("boundary", 0.01),
    ("tmesh", 0.02),
    ("space", 0.02),
    ("solid", 0.02),
    ("optimise", 0.72),
    ("certify", 0.04),
    ("write", 0.01),
    ("report", 0.09),
    ("evidence", 0.03),
    ("view", 0.03),
)


class Task:
    """Runs work(progress) in a thread; state: running, done, failed or cancelled."""

    def __init__(self, work, finished=None):
        self._work = work
        self._lock = threading.Lock()
        self._finished = finished  # called in the thread when it ends: only to wake somebody
        self._cancel = threading.Event()
        self._reached = 0
        self.stage, self.fraction, self.overall = "", 0.0, 0.0
        self.result, self.error = None, None
        self.state = "running"
        self.started = time.monotonic()
        self.cancelled_at = None
        self._thread = threading.Thread(target=self._run, name="tsolid", daemon=True)

    def start(self):
        self._thread.start()
        return self

    def _run(self):
        try:
            result = self._work(self.progress)
            with self._lock:
                self.result = result
                self.state = "cancelled" if self._cancel.is_set() else "done"
        except binding.Cancelled:
            with self._lock:
                self.state = "cancelled"
        except BaseException as error:  # whatever it is, it belongs to who asked for the work
            with self._lock:
                self.error = error
                self.state = "cancelled" if self._cancel.is_set() else "failed"
        if self._finished is not None:
            self._finished()

    def progress(self, stage, fraction):
        """Called by the work; true asks it to stop."""
        with self._lock:
            self.stage, self.fraction = stage, fraction
            self.overall = max(self.overall, self._share(stage, fraction))
        return self._cancel.is_set()

    def _share(self, stage, fraction):
        """The share of the whole that is done; stages that come again do not go back."""
        names = [name for name, _ in STAGES]
        if stage in names:
            self._reached = max(self._reached, names.index(stage))
        done = sum(share for _, share in STAGES[: self._reached])
        if stage == names[self._reached]:
            done += STAGES[self._reached][1] * min(1.0, max(0.0, fraction))
        return done

    def cancel(self):
        """Asks the work to stop at its next call of progress."""
        if self.cancelled_at is None:
            self.cancelled_at = time.monotonic()
        self._cancel.set()

    @property
    def running(self):
        return self.state == "running"

    def snapshot(self):
        """(stage, fraction of the stage, fraction of all) as last told."""
        with self._lock:
            return self.stage, self.fraction, self.overall

    def remaining(self):
        """Seconds that are probably left; None while that cannot be said."""
        spent = time.monotonic() - self.started
        if self.overall < 0.05 or spent < 1.0:
            return None
        return spent * (1.0 - self.overall) / self.overall

    def join(self, seconds=None):
        self._thread.join(seconds)
        return not self._thread.is_alive()
