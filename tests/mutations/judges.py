"""Several judges side by side, each with a copy of the copy."""

import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from pathlib import Path
from queue import SimpleQueue

from judge import Judge
from mutation import MutationError


class Judges:
    """Use as a context manager. One judge works in the copy itself; more of them need `unshare`."""

    def __init__(self, copy, count, folder):
        self.count = count
        self._copy = copy
        self._folder = folder
        self._workers = []
        self._idle = SimpleQueue()
        self._pool = ThreadPoolExecutor(count)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for worker in self._workers:
            worker.stdin.close()
        self._pool.shutdown(cancel_futures=True)
        for worker in self._workers:
            worker.wait()

    def _Start(self, number):
        copied = self._folder / "jobs" / str(number)
        shutil.rmtree(copied, ignore_errors=True)
        copied.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(["cp", "-a", "--reflink=auto", str(self._copy.source), str(copied)], check=True)
        return subprocess.Popen(
            ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--map-root-user"]), sys.executable,
             str(Path(__file__).with_name("judge.py")), str(self._copy.source), str(copied)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def _Judge(self, *task):
        if not self._workers:
            return Judge(self._copy, *task)
        worker = self._idle.get()
        worker.stdin.write(json.dumps(task) + "\n")
        worker.stdin.flush()
        line = worker.stdout.readline()
        if not line:
            raise MutationError(f"a judge ended with {worker.wait()}; --jobs needs a mount namespace (unshare --mount)")
        self._idle.put(worker)
        return json.loads(line)

    def Map(self, function, items):
        """The results of function(item), several at once, in the order of the items."""
        return list(self._pool.map(function, items))

    def Judged(self, tasks):
        """Yields (key, *result of judge.Judge) of each of `tasks`, an iterator of (key, name, text, asks), as they are done.
        A task is taken from the iterator when a judge is free for it; where that waits for results, the iterator may
        yield None."""
        if self.count > 1 and not self._workers:
            self._workers = self.Map(self._Start, range(self.count))
            for worker in self._workers:
                self._idle.put(worker)
        running, isOver = {}, False
        while True:
            while not isOver and len(running) < self.count:
                task = next(tasks, StopIteration)
                isOver = task is StopIteration
                if isOver or task is None:
                    break
                running[self._pool.submit(self._Judge, *task[1:])] = task[0]
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), *future.result()
