#!/usr/bin/env python3
"""Renders with MPI ranks and compares the files with those of one process, byte for byte."""
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ["RAYGRAPH"]
PROGRAM_MPI = os.environ["RAYGRAPH_MPI"]
MPIRUN = os.environ["MPIRUN"]
CORNELL = ROOT / "scenes" / "cornell.gltf"


def mpi(ranks, *arguments):
    """The command line of so many ranks, more than cores, as whoever runs this."""
    return [MPIRUN, "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), PROGRAM_MPI, *map(str, arguments)]


def catches(process, number):
    """Whether the process has a handler for the signal yet."""
    for line in pathlib.Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("SigCgt:"):
            return int(line.split()[1], 16) >> (number - 1) & 1
    return False


class MpiTest(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def run_in(self, command, status=0):
        result = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        return result

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def test_any_number_of_ranks_writes_the_files_of_one_process(self):
        picture = ["render", CORNELL, "--size", "40x30", "--spp", "37", "--max-depth", "4", "--aov", "all",
                   "--light-group", "lamp=*"]
        self.run_in([PROGRAM, *map(str, picture), "-o", "one.exr", "-o", "one.png"])
        for ranks in 1, 3:
            with self.subTest(ranks=ranks):
                result = self.run_in(mpi(ranks, *picture, "-o", "all.exr", "-o", "all.png"))
                self.assertEqual(self.bytes_of("all.exr"), self.bytes_of("one.exr"))
                self.assertEqual(self.bytes_of("all.png"), self.bytes_of("one.png"))
                self.assertEqual(result.stdout.count("samples a pixel"), 1, result.stdout)

    # Sums are sent 2^18 pixels at a time: the last 3056 are a second piece
    def test_large_pictures_are_added_piece_by_piece(self):
        picture = ["render", CORNELL, "--size", "520x510", "--spp", "2", "--view", "albedo", "--camera",
                   "0 1 0 0 0.3 -0.5 0 1 0 60"]
        self.run_in([PROGRAM, *map(str, picture), "--crop", "0,505,520,5", "-o", "last.exr", "--report", "last.json"])
        self.assertGreater(min(json.loads(self.bytes_of("last.json"))["image"]["mean"]), 0.1)
        self.run_in([PROGRAM, *map(str, picture), "-o", "one.exr"])
        self.run_in(mpi(2, *picture, "-o", "all.exr"))
        self.assertEqual(self.bytes_of("all.exr"), self.bytes_of("one.exr"))

    def test_more_ranks_than_samples(self):
        picture = ["render", CORNELL, "--size", "16x16", "--spp", "1", "--aov", "depth"]
        self.run_in([PROGRAM, *map(str, picture), "-o", "one.exr"])
        self.run_in(mpi(3, *picture, "-o", "all.exr"))
        self.assertEqual(self.bytes_of("all.exr"), self.bytes_of("one.exr"))

    def test_error_is_reached_at_the_same_sample(self):
        """Also where a render was left: what was measured before is the root's to know; and at 64 samples one rank alone
        has a new one."""
        picture = ["render", CORNELL, "--size", "12x12", "--max-depth", "2", "--error", "0.35"]
        self.run_in([PROGRAM, *map(str, picture), "-o", "one.exr"])
        self.run_in(mpi(3, *picture, "-o", "all.exr"))
        self.assertEqual(self.bytes_of("all.exr"), self.bytes_of("one.exr"))
        for before in "63", "200":
            with self.subTest(before=before):
                self.run_in([PROGRAM, *map(str, picture), "--spp", before, "-o", "part.exr"])
                self.run_in(mpi(3, "render", CORNELL, "--resume", "part.exr", "--error", "0.35", "-o", "all.exr"))
                self.assertEqual(self.bytes_of("all.exr"), self.bytes_of("one.exr"))

    def test_several_pictures_and_a_time(self):
        views = ["--camera", "0 1 3.2 0 1 0 0 1 0 40", "--camera", "0 1.5 3 0 1 0 0 1 0 40"]
        picture = ["render", CORNELL, "--size", "16x16", "--spp", "5", *views]
        self.run_in([PROGRAM, *map(str, picture), "-o", "one.{camera}.exr"])
        self.run_in(mpi(2, *picture, "-o", "all.{camera}.exr"))
        for camera in 0, 1:
            self.assertEqual(self.bytes_of(f"all.{camera}.exr"), self.bytes_of(f"one.{camera}.exr"))
        timed = self.run_in(mpi(3, "render", CORNELL, "--size", "16x16", "--time", "0.5", "-o", "timed.exr"))
        self.assertNotIn("stopped", timed.stderr)
        self.assertTrue(self.bytes_of("timed.exr"))

    def start(self, command):
        process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.kill)
        return process

    def rank_of(self, process, rank):
        """The process number of a rank."""
        for candidate in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                variables = (candidate / "environ").read_bytes().split(b"\0")
                parent = (candidate / "stat").read_text().rsplit(")", 1)[1].split()[1]
            except OSError:
                continue
            if parent == str(process.pid) and f"OMPI_COMM_WORLD_RANK={rank}".encode() in variables:
                return int(candidate.name)
        return None

    def wait_for(self, condition, process):
        end = time.monotonic() + 120
        while time.monotonic() < end and process.poll() is None:
            value = condition()
            if value:
                return value
            time.sleep(0.01)
        self.fail("waited in vain; exit status " + str(process.poll()))

    def test_signal_to_any_rank_saves_and_ends_the_job(self):
        """SIGUSR1 saves and goes on; SIGTERM saves and ends, also where one of two outputs cannot be written; so does
        SIGINT, with status 0; the render resumed by other ranks is that of one run."""
        picture = ["render", CORNELL, "--size", "48x48", "--spp", "600", "--max-depth", "2"]
        save = ["--checkpoint", "100", "--resume", "all.exr", "-o", "all.exr", "-o", "all.png"]
        process = self.start(mpi(2, *picture, *save))
        other = self.wait_for(lambda: self.rank_of(process, 1), process)
        self.wait_for(lambda: catches(other, signal.SIGUSR1), process)
        os.kill(other, signal.SIGUSR1)
        self.wait_for((self.folder / "all.png").exists, process)
        self.assertIsNone(process.poll(), "it goes on")
        (self.folder / "all.png").unlink()
        (self.folder / "all.png").mkdir()
        os.kill(other, signal.SIGTERM)
        output = process.communicate(timeout=60)[0]
        self.assertEqual(process.returncode, 75, output)
        self.assertIn("stopped after", output)
        self.assertIn("all.png: cannot write", output)
        (self.folder / "all.png").rmdir()
        process = self.start(mpi(3, *picture, *save))
        other = self.wait_for(lambda: self.rank_of(process, 2), process)
        self.wait_for(lambda: catches(other, signal.SIGINT), process)
        os.kill(other, signal.SIGINT)
        output = process.communicate(timeout=60)[0]
        self.assertEqual(process.returncode, 0, output)
        self.assertIn("stopped after", output)
        self.run_in(mpi(3, *picture, *save))
        self.run_in([PROGRAM, *map(str, picture), "-o", "one.exr"])
        self.assertEqual(self.bytes_of("all.exr"), self.bytes_of("one.exr"))
        again = self.run_in(mpi(2, *picture, *save))
        self.assertIn("is complete", again.stdout)

    def test_failure_ends_the_job_with_one_line(self):
        (self.folder / "bad.gltf").write_text("{")
        for arguments, status, line in (
            (["render", "bad.gltf", "-o", "a.exr"], 4, "bad.gltf"),
            (["render", CORNELL, "--spp", "0", "-o", "a.exr"], 2, "--spp"),
            (["render", CORNELL, "-o", "missing/a.exr"], 1, "missing"),
            (["render", CORNELL, "--camera", "top", "-o", "a.exr"], 2, "top"),
            (["merge", "a.exr", "b.exr", "-o", "c.exr"], 2, "raygraph-mpi renders"),
        ):
            with self.subTest(line=line):
                result = self.run_in(mpi(2, *arguments), status)
                said = [text for text in result.stderr.splitlines() if text.startswith("raygraph")]
                self.assertEqual(len(said), 1, result.stderr)
                self.assertIn(line, said[0])

    def test_rank_that_dies_ends_the_job_and_leaves_the_checkpoint(self):
        """Rank 1 stops before its sums are added for a second checkpoint: rank 2 waits in the barrier before that,
        rank 0 for what rank 1 has rendered."""
        picture = ["render", CORNELL, "--size", "24x24", "--spp", "1000000", "--max-depth", "2"]
        process = self.start(mpi(3, *picture, "--checkpoint", "100", "--resume", "all.exr", "-o", "all.exr"))
        root, dying = (self.wait_for(lambda rank=rank: self.rank_of(process, rank), process) for rank in (0, 1))
        for rank in root, dying:
            self.wait_for(lambda rank=rank: catches(rank, signal.SIGUSR1), process)
        os.kill(root, signal.SIGUSR1)
        self.wait_for((self.folder / "all.exr").exists, process)
        before = self.bytes_of("all.exr")
        os.kill(dying, signal.SIGSTOP)
        os.kill(root, signal.SIGUSR1)
        time.sleep(2)  # a block takes a second
        self.assertIsNone(process.poll(), "it waits")
        os.kill(dying, signal.SIGKILL)
        output = process.communicate(timeout=60)[0]
        self.assertNotEqual(process.returncode, 0, output)
        self.assertEqual(self.bytes_of("all.exr"), before)
        self.run_in([PROGRAM, "render", str(CORNELL), "--resume", "all.exr", "--time", "0.1", "-o", "more.exr"])


if __name__ == "__main__":
    unittest.main()
