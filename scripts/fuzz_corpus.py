#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Packs what libFuzzer found into the corpora that tests replay, and back.

    scripts/fuzz_corpus.py pack [--build build/fuzz] [--bytes 12000] [READER...]
    scripts/fuzz_corpus.py unpack FOLDER [READER...]

pack: for each reader the inputs in build/fuzz/corpus/READER that go where neither a sound file nor a smaller input goes (libFuzzer
-merge=1), the smallest first until the archive would pass --bytes: tests/fuzz/corpus/READER.tar.zst (tar --zstd -tf shows it). unpack: FOLDER/READER/*, to begin a long run with.
"""
import argparse
import io
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CORPORA = ROOT + "/tests/fuzz/corpus"


def fuzzer(build, reader=None, arguments=(), **environment):
    given = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1", **environment}
    if reader:
        given["GRTX_FUZZ_READER"] = reader
    return subprocess.run([build + "/tests/fuzz_readers", *arguments], env=given, capture_output=True, text=True, check=False)


def contents(folder):
    inputs = []
    for name in os.listdir(folder):
        with open(f"{folder}/{name}", "rb") as file:
            inputs.append(file.read())
    return sorted(inputs, key=lambda i: (len(i), i))


def archive(inputs):
    """The same bytes from the same inputs, whoever packs them."""
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for number, data in enumerate(inputs):
            member = tarfile.TarInfo(f"{number:04}")
            member.size = len(data)
            tar.addfile(member, io.BytesIO(data))
    tar = stream.getvalue()
    return subprocess.run(["zstd", "-19", "-q", f"--stream-size={len(tar)}"], input=tar, capture_output=True, check=True).stdout


def pack(build, reader, most):
    with tempfile.TemporaryDirectory() as work:
        if fuzzer(build, reader, GRTX_FUZZ_SEEDS=work + "/sound").returncode:
            sys.exit(f"{reader}: a sound file is refused")
        sound = contents(work + "/sound")
        os.mkdir(work + "/least")
        found = f"{build}/corpus/{reader}"
        if os.path.isdir(found):
            fuzzer(build, reader, ["-merge=1", "-max_len=65536", "-timeout=20", work + "/least", work + "/sound", found])
        others = [i for i in contents(work + "/least") if i and i not in sound]
        low, high = 0, len(others)
        while low < high:  # as many as fit
            middle = (low + high + 1) // 2
            if len(archive(others[:middle])) <= most:
                low = middle
            else:
                high = middle - 1
        os.makedirs(CORPORA, exist_ok=True)
        packed = archive(others[:low])
        with open(f"{CORPORA}/{reader}.tar.zst", "wb") as file:
            file.write(packed)
        print(f"{reader}: {low} of {len(others)} inputs, {len(packed)} B", flush=True)


def unpack(folder, reader):
    data = subprocess.run(["zstd", "-dcq", f"{CORPORA}/{reader}.tar.zst"], capture_output=True, check=True).stdout
    shutil.rmtree(f"{folder}/{reader}", ignore_errors=True)
    with tarfile.open(fileobj=io.BytesIO(data)) as tar:
        tar.extractall(f"{folder}/{reader}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    commands = parser.add_subparsers(dest="command", required=True)
    packs = commands.add_parser("pack")
    packs.add_argument("--build", default=ROOT + "/build/fuzz")
    packs.add_argument("--bytes", type=int, default=12000)
    unpacks = commands.add_parser("unpack")
    unpacks.add_argument("folder")
    for command in (packs, unpacks):
        command.add_argument("readers", nargs="*")
    options = parser.parse_args()
    if options.command == "pack":
        for reader in options.readers or fuzzer(options.build).stdout.split():
            pack(options.build, reader, options.bytes)
    else:
        for reader in options.readers or [f.removesuffix(".tar.zst") for f in sorted(os.listdir(CORPORA))]:
            unpack(options.folder, reader)


if __name__ == "__main__":
    main()
