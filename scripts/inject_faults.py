#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lets each system call, allocation and SQLite call of grtx fail once; kills it; takes its power away.

    scripts/inject_faults.py [--program build/release/grtx] [--library build/release/tests/libfault_injector.so]
                             [--parts faults,kills,power] [--commands trace,sim,...] [--most N] [--kills N] [--jobs N]

Commands run on tiny inputs, with the library preloaded (tests/faults/fault_injector.cpp):

faults  the n-th call of a class fails, for each n (--most N: N of them, evenly spread; allocations: the first of each place
        in the program and its libraries, and N at random).
        Afterwards each output is the old file or the new one, whole; nothing partial is left; the exit code is 2 (a file) or
        3 (memory, processes), or 0 with all outputs; standard error is one line. A sweep or search may end with 1 (a point
        failed), and the next one, --retry, gives what an undisturbed one gives.
kills   SIGKILL after a random time. Old file or new; the next run gives what an undisturbed one gives; no process stays.
power   what was not synced is lost: for moments between two changes the folder is made anew, once with nothing but what was
        synced (names by a sync of their folder), and once with all names but only synced content.

Prints a table for docs/validation.md; exit code 1 when a rule did not hold.
"""
import argparse
import collections
import concurrent.futures
import ctypes
import hashlib
import json
import mmap
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CLASSES = ["open_read", "open_write", "write", "sync", "rename", "resize", "remove", "make_folder", "start_process",
           "allocate", "sqlite"]
LOOK_FOR_SITES = len(CLASSES)
STATE = struct.Struct("<QQQ16Q")
SITES = 1 << 15
RECORD = struct.Struct("<IIIIQQ")
CREATED, WROTE, RESIZED, SYNCED, FOLDER_SYNCED, RENAMED, REMOVED, FOLDER_MADE = range(1, 9)
SECONDS = 120  # of one run, then it hangs
PLAN = f"""base = '{ROOT}/configs/small.toml'
designs = ['baseline', 'grtx']
[[scene]]
preset = 'object'
count = 300
seed = 7
width = 4
height = 4
[grid]
rt.warp_buffer.entries = [2]
"""
SEARCH = f"""base = '{ROOT}/configs/small.toml'
[[scene]]
preset = 'object'
count = 300
seed = 7
width = 4
height = 4
[[parameter]]
key = 'rt.warp_buffer.entries'
values = [2, 4]
[[objective]]
value = 'gpu.time_us'
[reference]
rt.warp_buffer.entries = 4
[search]
population = 8
candidates = 2
path = false
"""


# What limits the figures of a small launch, which a run says whatever happens to its files.
NOTE = r"grtx: \w+: a launch of .* does not fill.*\n"
# glibc 2.41 ends a process that has no memory for the destructor of a thread_local of any library; no exception comes to us.
NO_MEMORY_FOR_THE_LIBRARY = "Fatal glibc error: failed to register TLS destructor: out of memory"


class Program:
    def __init__(self, path, library):
        self.path, self.library = path, library

    def start(self, arguments, folder, environment=None, **more):
        # SystemC's pool of small objects (2.3.4) does not look whether malloc gave it memory, and reads this variable
        # before main: without the pool it asks operator new.
        env = {**os.environ, "LC_ALL": "C", "TMPDIR": folder + "/tmp", "SYSTEMC_MEMPOOL_DONT_USE": "1", **(environment or {})}
        return subprocess.Popen([self.path, *arguments], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                env=env, **more)

    def run(self, arguments, folder, environment=None):
        """Exit code (negative: signal, None: hangs) and standard error."""
        with tempfile.TemporaryFile() as errors:
            process = self.start(arguments, folder, environment, stderr=errors)
            try:
                code = process.wait(SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                code = None
            errors.seek(0)
            return code, errors.read().decode(errors="replace")


class Injector:
    """The state file of one run."""

    def __init__(self, program, folder):
        self.program, self.folder, self.path = program, folder, folder + ".state"
        with open(self.path, "wb") as file:
            file.truncate(STATE.size + 2 * 8 * SITES)

    def environment(self, log=""):
        more = {"GRTX_FAULT_LOG": log} if log else {}
        return {"LD_PRELOAD": self.program.library, "GRTX_FAULT_STATE": self.path, "GRTX_FAULT_FOLDER": self.folder, **more}

    def arm(self, what, at):
        with open(self.path, "r+b") as file:
            file.write(STATE.pack(what, at, 0, *[0] * 16))

    def read(self):
        with open(self.path, "rb") as file:
            fields = STATE.unpack(file.read(STATE.size))
            sites = struct.unpack(f"<{2 * SITES}Q", file.read())
        return fields[2], fields[3:3 + len(CLASSES)], sorted(n for n in sites[SITES:] if n)


def without_host(text):
    """Statistics without wall times and the host's."""
    document = json.loads(text)

    def clean(node):
        if isinstance(node, dict):
            return {k: clean(v) for k, v in node.items() if not re.search(r"^host\.|seconds|per_second", k)}
        return [clean(v) for v in node] if isinstance(node, list) else node
    return json.dumps(clean(document)).encode()


class Command:
    """One that writes files: `outputs` are there before, with other content."""
    resumes = False

    def __init__(self, name, arguments, outputs):
        self.name, self.arguments, self.outputs = name, arguments, outputs
        self.expected = {}

    def prepare(self, program, inputs, folder):
        self.inputs = inputs
        self.old = {name: f"old {name}".encode() for name in self.outputs}
        self.fresh(folder)
        code, errors = program.run(self.arguments, folder)
        assert code == 0, (self.name, errors)
        self.expected = {name: self.content(folder, name) for name in self.outputs}

    def fresh(self, folder):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.inputs, folder)
        os.makedirs(folder + "/tmp", exist_ok=True)
        for name, content in self.old.items():
            with open(f"{folder}/{name}", "wb") as file:
                file.write(content)

    def content(self, folder, name):
        try:
            with open(f"{folder}/{name}", "rb") as file:
                content = file.read()
        except FileNotFoundError:
            return None
        if name.endswith(".json") and content != self.old.get(name):
            try:
                return without_host(content)
            except ValueError:
                return b"no JSON: " + content[:50]
        return content

    def outcome(self, folder, allow_partial=False):
        """('old' | 'new' | 'some', what is wrong)"""
        kinds = set()
        for name in self.outputs:
            content = self.content(folder, name)
            if content == self.expected[name]:
                kinds.add("new")
            elif content == self.old[name]:
                kinds.add("old")
            else:
                return "", f"{name} is neither the old file nor the new one"
        left = [name for name in os.listdir(folder) if ".partial" in name]
        if left and not allow_partial:
            return "", f"{left[0]} is left"
        return (kinds.pop() if len(kinds) == 1 else "some"), ""

    def heal(self, program, folder):
        """What is wrong after the next run, undisturbed."""
        code, errors = program.run(self.arguments, folder)
        if code != 0:
            return f"the next run ends with {code}: {errors.strip()}"
        kind, wrong = self.outcome(folder)
        return wrong or ("" if kind == "new" else "the next run does not give the expected files")

    def judge(self, program, folder, what, code, errors, fired):
        """(outcome, what is wrong) after a fault."""
        kind, wrong = self.outcome(folder, allow_partial=what in ("remove", "allocate"))
        if wrong:
            return "", wrong
        errors = re.sub(NOTE, "", errors)
        if code == 0 and (kind != "new" or errors):
            return "", f"exit code 0, files: {kind}, standard error: {errors.strip()[:200]!r}"
        return self.judge_end(what, code, errors) or (f"exit {code}, {kind}", "")

    def judge_end(self, what, code, errors):
        if code is None:
            return "", "hangs"
        if what == "allocate" and code == -signal.SIGABRT and errors.strip() == NO_MEMORY_FOR_THE_LIBRARY:
            return f"signal {-code}, of the C library", ""
        if code < 0:
            return "", f"ends by signal {-code}: {errors.strip()[-200:]!r}"
        # A library may report what it lacks as the failure of a file; a sweep's tasks give a sweep their reason.
        right = {"allocate": {0, 2, 3}, "start_process": {0, 3}}.get(what, {0, 2}) | ({1, 2} if self.resumes else set())
        if code not in right:
            return "", f"exit code {code}: {errors.strip()[:200]!r}"
        if code > 1 and not (errors.startswith("grtx: ") and errors.count("\n") == 1):
            return "", f"standard error: {errors[:300]!r}"
        return None


class Resumed(Command):
    """A sweep or search: run again it ends as if nothing had happened."""
    resumes = True

    def __init__(self, name):
        super().__init__(name, [name, "plan.toml", "-o", "db.sqlite", "--jobs", "1", "--quiet"], [])

    def prepare(self, program, inputs, folder):
        self.inputs, self.old = inputs + "." + self.name, {}
        os.makedirs(self.inputs, exist_ok=True)
        with open(self.inputs + "/plan.toml", "w", encoding="utf-8") as file:
            file.write(PLAN if self.name == "sweep" else SEARCH)
        self.fresh(folder)
        code, errors = program.run(self.arguments, folder)
        assert code == 0, (self.name, errors)
        self.database = self.inputs + ".expected.sqlite"
        shutil.copy(folder + "/db.sqlite", self.database)

    def judge(self, program, folder, what, code, errors, fired):
        end = self.judge_end(what, code, errors)
        if end and end[1]:
            return end
        wrong = self.heal(program, folder)
        return ("", wrong) if wrong else (f"exit {code}, healed", "")

    def heal(self, program, folder):
        code, errors = program.run(self.arguments + ["--retry"], folder)
        if code != 0:
            return f"the next run ends with {code}: {errors.strip()[:300]}"
        compared = subprocess.run([program.path, "sweep", "--compare", self.database, "db.sqlite"], cwd=folder,
                                  capture_output=True, text=True, check=False)
        if compared.returncode != 0:
            return f"the next run gives other results: {(compared.stdout + compared.stderr).strip()[:300]}"
        left = sorted(set(os.listdir(folder)) - {"plan.toml", "db.sqlite", "traces", "tmp"})
        return f"{left[0]} is left" if left else ""


def commands_of(names):
    view = ["--scene", "s.ply", "--cameras", "s.cameras.json", "--width", "4", "--height", "4", "--accel", "tlas-tri20",
            "--checkpoint", "on", "--threads", "1", "--quiet"]
    known = {
        "synth": Command("synth", ["synth", "--preset", "object", "--count", "50", "--seed", "2", "-o", "n.ply", "--quiet"],
                         ["n.ply", "n.cameras.json"]),
        "trace": Command("trace", ["trace", *view, "-o", "n.grtx", "--image", "n.png", "--stats", "n.json"],
                         ["n.grtx", "n.png", "n.json"]),
        "sim": Command("sim", ["sim", "t.grtx", "--config", f"{ROOT}/configs/small.toml", "--stats", "n.json", "--vcd",
                               "n.vcd", "--vcd-window", "0:200", "--quiet"], ["n.json", "n.vcd"]),
        "report": Command("report", ["report", "in.sqlite", "-o", "n.html", "--quiet"], ["n.html"]),
        "sweep": Resumed("sweep"),
        "search": Resumed("search"),
    }
    return [known[name] for name in names]


def make_inputs(program, folder):
    os.makedirs(folder)
    os.makedirs(folder + "/tmp")
    for arguments in (["synth", "--preset", "object", "--count", "60", "--seed", "1", "-o", "s.ply"],
                      ["trace", "--scene", "s.ply", "--cameras", "s.cameras.json", "--width", "4", "--height", "4",
                       "--accel", "tlas-tri20", "--checkpoint", "on", "-o", "t.grtx"]):
        code, errors = program.run(arguments + ["--quiet"], folder)
        assert code == 0, errors
    with open(folder + "/plan.toml", "w", encoding="utf-8") as file:
        file.write(PLAN)
    code, errors = program.run(["sweep", "plan.toml", "-o", "in.sqlite", "--quiet"], folder)
    assert code == 0, errors
    shutil.rmtree(folder + "/traces")
    for name in os.listdir(folder + "/tmp"):
        os.remove(f"{folder}/tmp/{name}")


def some_of(numbers, most):
    numbers = sorted(set(numbers))
    if not most or len(numbers) <= most:
        return numbers
    return [numbers[i * (len(numbers) - 1) // max(1, most - 1)] for i in range(most)]


class Table:
    def __init__(self):
        self.rows, self.wrong = [], []

    def add(self, command, what, tried, outcomes):
        text = ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items()))
        self.rows.append(f"| {command} | {what} | {tried} | {text} |")
        print(self.rows[-1], flush=True)

    def fail(self, where, why):
        self.wrong.append(f"{where}: {why}")
        print(f"WRONG {self.wrong[-1]}", file=sys.stderr, flush=True)


def faults(program, command, folder, most, table, jobs, rng):
    injector = Injector(program, folder)
    command.fresh(folder)
    injector.arm(LOOK_FOR_SITES, 0)
    code, errors = program.run(command.arguments, folder, injector.environment())
    if code != 0:
        table.fail(f"{command.name}, preloaded", errors)
        return
    _, counts, sites = injector.read()
    for index, what in enumerate(CLASSES):
        count = counts[index]
        numbers = some_of(range(1, count + 1), most)
        of = f"{len(numbers)} of {count}" if len(numbers) < count else f"{count}"
        if what == "allocate":
            more = rng.sample(range(1, count + 1), min(most or 300, count))
            numbers = sorted(set(some_of(sites, most)) | set(more))
            of = f"{len(numbers)} of {count}, {len(sites)} places"

        def one(number, index=index, what=what):
            own = f"{folder}.{what}.{number}"
            mine = Injector(program, own)
            command.fresh(own)
            mine.arm(index, number)
            code, errors = program.run(command.arguments, own, mine.environment())
            fired = mine.read()[0]
            # A call that another order of processes did not reach.
            kind, wrong = ("not reached", "") if not fired and code == 0 else command.judge(program, own, what, code, errors, fired)
            shutil.rmtree(own)
            os.remove(mine.path)
            return number, kind, wrong
        outcomes = collections.Counter()
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            for number, kind, wrong in pool.map(one, numbers):
                outcomes[kind or "WRONG"] += 1
                if wrong:
                    table.fail(f"{command.name}, {what} {number}", wrong)
        if count:
            table.add(command.name, what, of, outcomes)


def kills(program, command, folder, count, table, rng):
    command.fresh(folder)
    start = time.monotonic()
    program.run(command.arguments, folder)
    seconds = time.monotonic() - start
    outcomes = collections.Counter()
    for number in range(count):
        command.fresh(folder)
        with tempfile.TemporaryFile() as errors:
            process = program.start(command.arguments, folder, stderr=errors)
            time.sleep(rng.uniform(0, 1.05 * seconds))
            process.send_signal(signal.SIGKILL)
            killed = process.wait() < 0
        kind, wrong = ("", "") if command.resumes else command.outcome(folder, allow_partial=True)
        if not wrong:
            wrong = command.heal(program, folder)
        outcomes["WRONG" if wrong else "had ended" if not killed else kind or "healed"] += 1
        if wrong:
            table.fail(f"{command.name}, kill {number}", wrong)
    table.add(command.name, "SIGKILL", count, outcomes)


class Disk:
    """A folder as it is, and as it is on the disk."""

    def __init__(self, folder):
        self.folder = folder
        self.names, self.content = {}, {}  # path: content's key; key: bytearray
        self.folders = {folder}
        self.disk_names, self.disk_content, self.disk_folders = {}, {}, {folder}
        self.waiting = []  # changes of names that no sync of a folder has reached
        self.inodes, self.count = {}, 0
        for path, _, files in os.walk(folder):
            self.folders.add(path)
            self.disk_folders.add(path)
            for name in files:
                whole = f"{path}/{name}"
                with open(whole, "rb") as file:
                    self.make(whole, os.stat(whole).st_ino, file.read())
                self.disk_names[whole] = self.names[whole]
                self.disk_content[self.names[whole]] = bytes(self.content[self.names[whole]])

    def make(self, path, inode, content=b""):
        self.count += 1
        self.names[path] = self.inodes[inode] = self.count
        self.content[self.count] = bytearray(content)

    @staticmethod
    def rename(names, change):
        kind, path, other, key = change
        if kind == CREATED:
            names[path] = key
        elif kind == REMOVED:
            names.pop(path, None)
        elif kind == RENAMED:
            names.pop(path, None)
            names[other] = key

    def apply(self, kind, inode, offset, path, other, data):
        key = self.inodes.get(inode)
        if kind == CREATED:
            self.make(path, inode)
            self.waiting.append((CREATED, path, "", self.names[path]))
        elif kind == WROTE and key is not None:
            content = self.content[key]
            content.extend(bytes(max(0, offset + len(data) - len(content))))
            content[offset:offset + len(data)] = data
        elif kind == RESIZED and key is not None:
            content = self.content[key]
            del content[offset:]
            content.extend(bytes(offset - len(content)))
        elif kind == SYNCED and key is not None:
            self.disk_content[key] = bytes(self.content[key])
        elif kind == FOLDER_MADE:
            self.folders.add(path)
            self.waiting.append((FOLDER_MADE, path, "", 0))
        elif kind == REMOVED:
            self.names.pop(path, None)
            self.folders.discard(path)
            self.waiting.append((REMOVED, path, "", 0))
        elif kind == RENAMED and path in self.names:
            change = (RENAMED, path, other, self.names[path])
            self.rename(self.names, change)
            self.waiting.append(change)
        elif kind == FOLDER_SYNCED:
            kept = []
            for change in self.waiting:
                if os.path.dirname(change[2] or change[1]) == path:
                    self.settle(change)
                else:
                    kept.append(change)
            self.waiting = kept

    def settle(self, change):
        if change[0] == FOLDER_MADE:
            self.disk_folders.add(change[1])
        elif change[0] == REMOVED:
            self.disk_folders.discard(change[1])
        self.rename(self.disk_names, change)

    def write(self, target, all_names):
        """What a power loss leaves: of names, those synced or all; of content, what was synced."""
        shutil.rmtree(target, ignore_errors=True)
        names, folders = (self.names, self.folders) if all_names else (self.disk_names, self.disk_folders)
        here = lambda path: target + path[len(self.folder):]
        for path in sorted(folders):
            if path == self.folder or os.path.isdir(os.path.dirname(here(path))):
                os.makedirs(here(path), exist_ok=True)
        for path, key in names.items():
            if os.path.isdir(os.path.dirname(here(path))):
                with open(here(path), "wb") as file:
                    file.write(self.disk_content.get(key, b""))
        os.makedirs(target + "/tmp", exist_ok=True)


def records_of(path):
    with open(path, "rb") as file:
        log = file.read()
    at, records = 0, []
    while at < len(log):
        kind, path_bytes, other_bytes, count, inode, offset = RECORD.unpack_from(log, at)
        at += RECORD.size
        path, at = log[at:at + path_bytes].decode(), at + path_bytes
        other, at = log[at:at + other_bytes].decode(), at + other_bytes
        data, at = log[at:at + count], at + count
        records.append((kind, inode, offset, path, other, data))
    return records


def power(program, command, folder, most, table):
    injector = Injector(program, folder)
    command.fresh(folder)
    disk = Disk(folder)
    log = folder + ".log"
    if os.path.exists(log):
        os.remove(log)
    code, errors = program.run(command.arguments, folder, injector.environment(log))
    if code != 0:
        table.fail(f"{command.name}, recorded", errors)
        return
    records = records_of(log)
    # Writes between two other changes differ in nothing that is on the disk.
    moments = [i for i, record in enumerate(records) if record[0] != WROTE]
    moments = set(some_of(moments + [len(records)], most))
    outcomes, tried, seen = collections.Counter(), 0, set()
    lost = folder + ".lost"
    for i in range(len(records) + 1):
        if i in moments:
            for all_names in (False, True):
                disk.write(lost, all_names)
                state = hash_of(lost)
                if state in seen:
                    continue
                seen.add(state)
                tried += 1
                kind, wrong = ("healed", "") if command.resumes else command.outcome(lost, allow_partial=True)
                if not wrong:
                    wrong = command.heal(program, lost)
                outcomes["WRONG" if wrong else kind] += 1
                if wrong:
                    what = "all names" if all_names else "synced names"
                    table.fail(f"{command.name}, power lost after change {i} of {len(records)}, {what}", wrong)
        if i < len(records):
            disk.apply(*records[i])
    table.add(command.name, "power", f"{tried} states of {len(records)} changes", outcomes)
    if not command.resumes:  # what a command has reported as done stays
        disk.write(lost, False)
        kind, wrong = command.outcome(lost, allow_partial=True)
        if wrong or kind != "new":
            table.fail(f"{command.name}, power lost after its end", wrong or f"files: {kind}")


def hash_of(folder):
    digest = hashlib.sha256()
    for path, folders, files in sorted(os.walk(folder)):
        for name in sorted(files):
            with open(f"{path}/{name}", "rb") as file:
                digest.update(f"{path}/{name}".encode() + b"\0" + file.read() + b"\0")
        digest.update(path.encode())
    return digest.digest()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--program", default=ROOT + "/build/release/grtx")
    parser.add_argument("--library", default=ROOT + "/build/release/tests/libfault_injector.so")
    parser.add_argument("--parts", default="faults,kills,power")
    parser.add_argument("--commands", default="synth,trace,sim,report,sweep,search")
    parser.add_argument("--most", type=int, default=0, help="calls of a class, and moments of power loss (default: all)")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program = Program(os.path.abspath(options.program), os.path.abspath(options.library))
    table = Table()
    rng = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as top:
        top = os.path.realpath(top)
        make_inputs(program, top + "/inputs")
        print("| command | what fails | tried | outcomes |\n|---|---|---|---|")
        for command in commands_of(options.commands.split(",")):
            folder = f"{top}/{command.name}"
            command.prepare(program, top + "/inputs", folder)
            if "faults" in options.parts:
                faults(program, command, folder, options.most, table, options.jobs, rng)
            if "kills" in options.parts:
                kills(program, command, folder, options.kills, table, rng)
            if "power" in options.parts:
                power(program, command, folder, options.most, table)
    for line in table.wrong:
        print(f"WRONG {line}", file=sys.stderr)
    return 1 if table.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
