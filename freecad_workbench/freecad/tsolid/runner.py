# SPDX-License-Identifier: LGPL-2.1-or-later
"""Long work behind a window: a thread that works, a timer that looks, and one line executed on the
main thread when the work is ready.
"""

import time

import FreeCAD
import FreeCADGui as Gui
from PySide import QtCore, QtGui

from . import actions, task

POLL = 40  # milliseconds
_running = []


def tr(text):
    return FreeCAD.Qt.translate("tsolid", text)


def reference(obj):
    """How a line of Python calls a document object."""
    return "App.getDocument(%r).getObject(%r)" % (str(obj.Document.Name), str(obj.Name))


def line_of(function, obj, **keywords):
    """The line that a button leaves: also what it executes."""
    words = [reference(obj)] + ["%s=%r" % (k, v) for k, v in keywords.items() if v is not None]
    return "import freecad.tsolid as ts; ts.%s(%s)" % (function, ", ".join(words))


def execute(line):
    """Runs a line as if it had been typed: it appears in the Python console and in macros."""
    Gui.doCommand(line)


def say(text):
    """One sentence in the status bar."""
    Gui.getMainWindow().statusBar().showMessage(text, 10000)


class Work(QtCore.QObject):
    """A function of progress that runs in a thread for a document object, and the timer that looks
    after it on the main thread."""

    def __init__(self, function, given):
        super().__init__()
        self.given = given
        self.document = given.Document.Name
        self.lost = ""
        self.timer = QtCore.QTimer()
        self.timer.setInterval(POLL)
        self.timer.timeout.connect(self._look)
        self.task = task.Task(function)

    def start(self):
        _running.append(self)
        _watch()
        self.task.start()
        self.timer.start()
        return self

    def cancel(self):
        self.task.cancel()

    @property
    def running(self):
        return self in _running

    def lose(self, sentence):
        """The object is going away: the work stops, and nothing is to be applied."""
        self.lost = sentence
        self.task.cancel()

    def _look(self):
        if self.task.running:
            self._go_on()
        else:
            self.timer.stop()
            self.timer.timeout.disconnect(self._look)  # it would keep what this holds for ever
            _running.remove(self)
            self._end()

    def _go_on(self):
        pass

    def _end(self):
        raise NotImplementedError


class Loading(Work):
    """Work that nobody waits for: take(result) is called when it is done, tell(error) when not."""

    def __init__(self, function, given, take, tell):
        super().__init__(function, given)
        self.take, self.tell = take, tell

    def drop(self):
        """Nobody wants it any more."""
        self.lost = self.lost or "dropped"
        self.cancel()

    def finish(self):
        """Somebody wants it now: waits."""
        self.task.join()
        self._look()

    def _look(self):
        if self.running:
            super()._look()

    def _end(self):
        take, tell, done = self.take, self.tell, self.task
        self.take = self.tell = self.task = None
        if done.state == "done" and not self.lost:
            take(done.result)
        elif done.state == "failed" and not self.lost:
            tell(done.error)


class Runner(Work):
    """One job. on_progress(stage, overall, remaining), on_end(state, result, sentence) are called
    on the main thread; longest is the longest time that this held it, in seconds, without what
    FreeCAD itself needs to draw a new shape."""

    def __init__(self, job, line, on_progress, on_end):
        super().__init__(job.run, job.given)
        self.job, self.line = job, line
        self.on_progress, self.on_end = on_progress, on_end
        self.longest = self.longest_cpu = 0.0

    def _look(self):
        start, cpu = time.perf_counter(), time.thread_time()
        super()._look()
        spent, cpu = time.perf_counter() - start, time.thread_time() - cpu
        ready = getattr(self.job.result, "prepared", None)
        if not self.running and ready is not None:
            spent -= ready.shown_in
            cpu -= ready.shown_in_cpu
        self.longest = max(self.longest, spent)
        self.longest_cpu = max(self.longest_cpu, cpu)

    def _go_on(self):
        stage, _, overall = self.task.snapshot()
        try:
            self.on_progress(stage, overall, self.task.remaining())
        except RuntimeError:  # whoever wanted to see it has been closed
            self.task.cancel()

    def _end(self):
        if self.lost:
            say(self.lost)
            self.on_end("lost", None, self.lost)
        elif self.task.state == "cancelled":
            self.on_end("cancelled", None, tr("Cancelled."))
        elif self.task.state == "failed":
            self.on_end("failed", None, sentence_of(self.task.error))
        else:
            self._apply()

    def _apply(self):
        try:
            with actions.ready(self.job):
                execute(self.line)
        except Exception as error:
            self.on_end("failed", None, sentence_of(error))
            return
        self.on_end("done", self.job.result, "")


def sentence_of(error):
    """An exception in the user's words."""
    if isinstance(error, MemoryError):
        return tr("There is not enough memory for this.")
    return str(error) or type(error).__name__


# ---- things that go away while work runs ---------------------------------------------------------


class _Observer:
    def slotDeletedDocument(self, doc):
        for runner in list(_running):
            if runner.document == doc.Name:
                runner.lose(tr("The document was closed: the work on it was stopped."))

    def slotDeletedObject(self, obj):
        for runner in list(_running):
            if runner.given is obj:
                runner.lose(tr("The part was deleted: the work on it was stopped."))


_observer = None


def _watch():
    global _observer
    if _observer is None:
        _observer = _Observer()
        FreeCAD.addDocumentObserver(_observer)
        QtGui.QApplication.instance().aboutToQuit.connect(stop_all)


def stop_all():
    """FreeCAD is closing: no thread may outlive it."""
    for runner in list(_running):
        runner.timer.stop()
        runner.task.cancel()
    for runner in list(_running):
        runner.task.join(5.0)
