#!/usr/bin/env python3
"""docs/cluster.md is true: its scripts, as they are printed there, run on a Slurm of one node.

Usage, within with_slurm: cluster_test.py FOLDER_OF_PROGRAMS SOURCE_TREE [UNITTEST OPTIONS]. Each test writes the page's
scripts to a folder of its own and submits them with a small scene and few samples in place of the page's.
"""

import base64
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROGRAMS = Path(sys.argv.pop(1)).resolve()
SOURCE = Path(sys.argv.pop(1)).resolve()
SCENE = str(SOURCE / "scenes/cornell.gltf")
BLOCK = re.compile(r"^<!-- file: ([\w.]+) -->\n```bash\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGE = dict(BLOCK.findall((SOURCE / "docs/cluster.md").read_text(encoding="utf-8")))


def Run(*words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=300, **options)
    if done.returncode != 0:
        raise AssertionError(f"{words}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def Until(what, isTrue, seconds=180):
    end = time.monotonic() + seconds
    while not isTrue():
        if time.monotonic() > end:
            raise AssertionError(f"not within {seconds} s: {what}\n" + Run("squeue", "--long"))
        time.sleep(0.1)


def JobFields(job):
    """Those of all tasks of a job; of all jobs for none."""
    return [dict(word.split("=", 1) for word in line.split() if "=" in word)
            for line in Run("scontrol", "--oneliner", "show", "job", *([job] if job else [])).splitlines()]


def AllJobs():
    """The names of those that Slurm still knows, by the number of the job or of the array."""
    if not Run("squeue", "--noheader", "--states=all"):
        return {}
    return {int(task.get("ArrayJobId", task["JobId"])): task["JobName"] for task in JobFields("")}


def WriteMovingScene(path):
    """The Cornell box, of which something rises by 0.1 m a second."""
    scene = json.loads(Path(SCENE).read_text(encoding="utf-8"))
    data = struct.pack("<2f6f", 0, 1, 0, 0, 0, 0, 0.1, 0)
    accessor = len(scene["accessors"])
    scene["buffers"].append({"byteLength": len(data),
                             "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()})
    view = {"bufferView": len(scene["bufferViews"]), "componentType": 5126, "count": 2}
    scene["bufferViews"].append({"buffer": len(scene["buffers"]) - 1, "byteLength": len(data)})
    scene["accessors"] += [{**view, "type": "SCALAR", "min": [0], "max": [1]}, {**view, "byteOffset": 8, "type": "VEC3"}]
    node = next(i for i, node in enumerate(scene["nodes"]) if "mesh" in node)
    scene["animations"] = [{"samplers": [{"input": accessor, "output": accessor + 1}],
                            "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}]}]
    path.write_text(json.dumps(scene), encoding="utf-8")


class ClusterTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="raygraph-cluster-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.environment = {**os.environ, "PATH": f"{PROGRAMS}:{os.environ['PATH']}"}
        for name, text in PAGE.items():
            (self.folder / name).write_text(text, encoding="utf-8")

    def tearDown(self):
        Run("scancel", "--user", os.getuid(), "--full")
        Until("the queue is empty", lambda: not Run("squeue", "--noheader"))

    def Replace(self, name, *pairs):
        """In a script: what this node and a test need otherwise. Each text must be on the page."""
        path = self.folder / name
        text = path.read_text(encoding="utf-8")
        for old, new in pairs:
            self.assertEqual(text.count(old), 1, f"docs/cluster.md, {name}: {old}")
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")

    def Submit(self, name, *pairs):
        """The jobs that the script submits, by their names; an array counts once."""
        self.Replace(name, *pairs)
        before = AllJobs()
        Run("bash", "-eu", name, cwd=self.folder, env=self.environment)
        return {jobName: job for job, jobName in AllJobs().items() if job not in before}

    def Logs(self):
        return "".join(f"--- {log.name}\n{log.read_text()}" for log in sorted(self.folder.glob("*.log")))

    def ExpectSuccess(self, job):
        Until(f"job {job} ends", lambda: all(task["JobState"] not in {"PENDING", "CONFIGURING", "RUNNING", "COMPLETING",
                                                                     "REQUEUED"} for task in JobFields(job)))
        for task in JobFields(job):
            self.assertEqual(task["JobState"], "COMPLETED", f"{task}\n{self.Logs()}")

    def Render(self, options):
        return Run("raygraph", "render", *options.split(), cwd=self.folder, env=self.environment)

    def ExpectSameBytes(self, name, other):
        self.assertTrue((self.folder / name).exists(), f"{name} is not there\n{self.Logs()}")
        self.assertEqual((self.folder / name).read_bytes(), (self.folder / other).read_bytes(), f"{name} and {other}")

class ShardsTest(ClusterTest):
    # 16 tasks for 10 samples: six have none, and are no failure, or the job that merges would not begin.
    def test_shards_of_an_array_merge_to_the_bits_of_one_run(self):
        jobs = self.Submit("submit_shards.sh", ("scene.gltf --size 3840x2160 --spp 4096", f"{SCENE} --size 16x16 --spp 10"))
        self.ExpectSuccess(jobs["shards"])
        self.assertEqual(len(JobFields(jobs["shards"])), 16)
        self.ExpectSuccess(jobs["merge"])
        self.assertEqual(len(list(self.folder.glob("part.*.exr"))), 10)
        self.assertEqual(self.Logs().count("has no sample to render"), 6, self.Logs())
        self.Render(f"{SCENE} --size 16x16 --spp 10 -o whole.exr")
        self.ExpectSameBytes("picture.exr", "whole.exr")

    def test_merging_does_not_begin_without_a_part(self):
        jobs = self.Submit("submit_shards.sh",
                           ("sbatch --parsable shards.sh", "sbatch --parsable --array=0-2 shards.sh"),
                           ("scene.gltf --size 3840x2160 --spp 4096", "missing.gltf --size 16x16 --spp 10"))
        Until("the merge is canceled", lambda: not Run("squeue", "--noheader"))
        self.assertEqual({task["ExitCode"] for task in JobFields(jobs["shards"])}, {"4:0"}, self.Logs())
        self.assertFalse((self.folder / "picture.exr").exists())

    def test_processes_in_the_tasks_of_an_array_divide_their_parts(self):
        self.Replace("shards.sh", ("--array=0-15", "--array=3-4"), ("--ntasks=1", "--ntasks=2"), ("exec raygraph", "exec srun raygraph"))
        jobs = self.Submit("submit_shards.sh", ("scene.gltf --size 3840x2160 --spp 4096", f"{SCENE} --size 16x16 --spp 9"))
        self.ExpectSuccess(jobs["shards"])
        self.ExpectSuccess(jobs["merge"])
        self.assertEqual([path.name for path in sorted(self.folder.glob("part.*"))],
                         [f"part.000{i}.exr" for i in range(4)])
        self.Render(f"{SCENE} --size 16x16 --spp 9 -o whole.exr")
        self.ExpectSameBytes("picture.exr", "whole.exr")

    def test_frames_of_an_array_are_the_sequence(self):
        WriteMovingScene(self.folder / "scene.gltf")
        options = "--frames 0.04:0.76:0.04 --size 16x16 --spp 2"
        job = self.Submit("submit_frames.sh", ("scene.glb --frames 0:9.96:0.04 --size 1920x1080 --spp 256", f"scene.gltf {options}"))["frames"]
        self.ExpectSuccess(job)
        self.Render(f"scene.gltf {options} -o whole.####.exr -o whole.####.png")
        frames = sorted(self.folder.glob("whole.*"))
        self.assertEqual(len(frames), 2 * 19)
        for frame in frames:
            self.ExpectSameBytes(frame.name.replace("whole", "frame"), frame.name)


class RequeueTest(ClusterTest):
    """A render that takes several seconds here."""

    PAGES = "scene.gltf --size 3840x2160 --spp 4096"
    OPTIONS = f"{SCENE} --size 64x64 --spp 400"

    def Restarts(self, job):
        return int(JobFields(job)[0]["Restarts"])

    def ExpectWhole(self, *names):
        self.Render(f"{self.OPTIONS} -o whole.exr -o whole.png")
        for name in names:
            self.ExpectSameBytes(name, "whole" + Path(name).suffix)

    def IsAlive(self, job):
        """There is nothing to wait for once it has failed."""
        state = JobFields(job)[0]["JobState"]
        self.assertNotIn(state, {"FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL"}, f"job {job}\n{self.Logs()}")
        return True

    def UntilRendering(self, job):
        """Until it has shown samples."""
        Until("there are samples", lambda: self.IsAlive(job) and re.search(r"\b[1-9]\d*/\d+ samples", self.Logs()))

    def UntilRequeued(self, job):
        Until("the job is requeued", lambda: self.IsAlive(job) and self.Restarts(job) == 1)

    def test_a_job_that_is_warned_goes_on_from_its_checkpoint(self):
        job = self.Submit("submit_requeue.sh", (self.PAGES, self.OPTIONS))["render"]
        self.UntilRendering(job)
        Run("scancel", "--batch", "--signal=USR2", job)
        self.UntilRequeued(job)
        self.assertTrue((self.folder / "out.exr").exists(), self.Logs())
        self.ExpectSuccess(job)
        self.assertIn(f"requeueing {job}", self.Logs())
        self.assertRegex(self.Logs(), r"400 samples a pixel, \d+ of them new")
        self.ExpectWhole("out.exr", "out.png")

    def test_a_job_that_is_preempted_goes_on_from_its_checkpoint(self):
        job = self.Submit("submit_requeue.sh", ("sbatch ", "sbatch --exclusive "), (self.PAGES, self.OPTIONS))["render"]
        self.UntilRendering(job)
        urgent = Run("sbatch", "--parsable", "--partition=urgent", "--exclusive", "--wrap", "sleep 1", cwd=self.folder)
        self.UntilRequeued(job)
        self.assertTrue((self.folder / "out.exr").exists(), self.Logs())
        self.ExpectSuccess(int(urgent))
        self.ExpectSuccess(job)
        self.assertRegex(self.Logs(), r"400 samples a pixel, \d+ of them new")
        self.ExpectWhole("out.exr", "out.png")

    def test_shards_that_are_requeued_merge_to_the_bits_of_one_run(self):
        jobs = self.Submit("submit_requeued_shards.sh", ("--array=0-15", "--array=0-1"), (self.PAGES, self.OPTIONS))
        shards = jobs["render"]
        self.UntilRendering(shards)
        Run("scancel", "--batch", "--signal=USR2", f"{shards}_0")
        self.UntilRequeued(f"{shards}_0")
        self.ExpectSuccess(shards)
        self.assertEqual(len(JobFields(shards)), 2)
        self.ExpectSuccess(jobs["merge"])
        self.ExpectWhole("picture.exr")

    def test_a_job_that_is_cancelled_saves_and_does_not_come_back(self):
        job = self.Submit("submit_requeue.sh", (self.PAGES, self.OPTIONS))["render"]
        self.UntilRendering(job)
        Run("scancel", job)
        Until("the job has ended", lambda: JobFields(job)[0]["JobState"] == "CANCELLED")
        Until("there is a checkpoint", lambda: (self.folder / "out.exr").exists())
        time.sleep(3)  # by which Slurm would have requeued it
        self.assertEqual(JobFields(job)[0]["JobState"], "CANCELLED", self.Logs())
        self.assertEqual(self.Restarts(job), 0)

    # As the site's own requeueing after a crash: nobody warns the program.
    def test_a_checkpoint_on_demand_survives_a_kill(self):
        job = self.Submit("submit_requeue.sh", (self.PAGES, self.OPTIONS))["render"]
        self.UntilRendering(job)
        Run("scancel", "--batch", "--signal=USR1", job)
        Until("there is a checkpoint", lambda: self.IsAlive(job) and (self.folder / "out.exr").exists())
        self.assertEqual(JobFields(job)[0]["JobState"], "RUNNING", self.Logs())
        Run("scontrol", "requeue", job)
        self.ExpectSuccess(job)
        self.ExpectWhole("out.exr", "out.png")


@unittest.skipUnless((PROGRAMS / "raygraph-mpi").exists(), "raygraph-mpi was built without MPI")
class MpiTest(ClusterTest):
    def test_ranks_of_a_job_render_one_picture(self):
        self.Replace("mpi.sh", ("--nodes=4", "--nodes=1"), ("--ntasks-per-node=1", "--ntasks-per-node=2"),
                     ("--cpus-per-task=8", "--cpus-per-task=1"))
        self.environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        job = self.Submit("submit_mpi.sh", ("scene.gltf --size 3840x2160 --spp 4096", f"{SCENE} --size 16x16 --spp 9"))["mpi"]
        self.ExpectSuccess(job)
        self.Render(f"{SCENE} --size 16x16 --spp 9 -o whole.exr -o whole.png")
        self.ExpectSameBytes("picture.exr", "whole.exr")
        self.ExpectSameBytes("picture.png", "whole.png")

    def test_ranks_that_would_have_parts_of_their_own_are_refused(self):
        self.environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        line = f"mpirun -n 2 --oversubscribe raygraph-mpi render {SCENE} --size 16x16 --shard auto -o part.####.exr"
        done = subprocess.run(line.split(),
                              cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("raygraph-mpi: --shard auto is another part for each rank", done.stderr)
        self.assertEqual(list(self.folder.glob("part.*")), [])


if __name__ == "__main__":
    os.environ["PATH"] = f"{PROGRAMS}:{os.environ['PATH']}"
    unittest.main(verbosity=2)
