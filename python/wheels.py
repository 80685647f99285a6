# SPDX-License-Identifier: Apache-2.0
"""Builds the package with the standard library alone (PEP 517 and 660): any Python from 3.11 on does it without a network."""
import base64
import hashlib
import io
import re
import tarfile
import tomllib
import zipfile
from pathlib import Path

TOP = Path(__file__).resolve().parent
PACKAGE = TOP / "grtx_tlm"
TIME = (1980, 1, 1, 0, 0, 0)  # the same files give the same wheel


def _version() -> str:
    found = re.search(r'^__version__ = "(.+)"$', (PACKAGE / "__init__.py").read_text(encoding="utf-8"), re.M)
    if found is None:
        raise ValueError(f"{PACKAGE}/__init__.py: has no __version__")
    return found[1]


def _name() -> str:
    return f"{PACKAGE.name}-{_version()}"


def _metadata() -> str:
    project = tomllib.loads((TOP / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {_version()}",
             f"Summary: {project['description']}", f"License: {project['license']['text']}",
             f"Requires-Python: {project['requires-python']}",
             *(f"Requires-Dist: {dependency}" for dependency in project["dependencies"]),
             "Description-Content-Type: text/markdown", "", (TOP / project["readme"]).read_text(encoding="utf-8")]
    return "\n".join(lines)


def _sources() -> dict[str, bytes]:
    return {path.relative_to(TOP).as_posix(): path.read_bytes() for path in sorted(PACKAGE.iterdir())
            if path.suffix == ".py" or path.name == "py.typed"}


def _write_wheel(folder: str, files: dict[str, bytes]) -> str:
    about = f"{_name()}.dist-info"
    wheel = "Wheel-Version: 1.0\nGenerator: grtx_tlm\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    files = {**files, f"{about}/METADATA": _metadata().encode(), f"{about}/WHEEL": wheel.encode()}
    record = [f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}"
              for name, data in files.items()]
    files[f"{about}/RECORD"] = "\n".join([*record, f"{about}/RECORD,,", ""]).encode()
    name = f"{_name()}-py3-none-any.whl"
    with zipfile.ZipFile(Path(folder, name), "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, TIME)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None) -> str:
    return _write_wheel(wheel_directory, _sources())


def build_editable(wheel_directory, config_settings=None, metadata_directory=None) -> str:
    return _write_wheel(wheel_directory, {f"{PACKAGE.name}.pth": f"{TOP}\n".encode()})


def build_sdist(sdist_directory, config_settings=None) -> str:
    files = {**_sources(), "PKG-INFO": _metadata().encode(),
             **{name: (TOP / name).read_bytes() for name in ("pyproject.toml", "README.md", "wheels.py")}}
    with tarfile.open(Path(sdist_directory, f"{_name()}.tar.gz"), "w:gz") as archive:
        for path, data in files.items():
            entry = tarfile.TarInfo(f"{_name()}/{path}")
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
    return f"{_name()}.tar.gz"
