#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""python/grtx_tlm as a package: one version, types that hold, calls that name the program's options, and a wheel that each
Python from 3.11 on builds and installs in a fresh environment without a network.

    python_package_test.py GRTX       Exit code 77: a Python package is missing.
"""
import inspect
import os
import shutil
import subprocess
import sys
import tempfile
import typing
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "python"), os.path.join(ROOT, "scripts")]
try:
    import matplotlib
    matplotlib.use("Agg")
    import cli_help
    import grtx_tlm
    from grtx_tlm import plots, runs
except ImportError as error:
    print(f"skipped: {error}; Debian packages: python3-numpy python3-pandas python3-matplotlib")
    sys.exit(77)

PROGRAM = ""
SHOWS = {"help", "help_all", "quiet", "json", "list_config", "list_statistics"}  # what these print, a call gives
PER_RUN = {"save_state", "vcd", "vcd_scope", "vcd_window", "vcd_level", "timeline", "timeline_window", "heatmap"}


def calls():
    """Every function that users call, and every method."""
    for module in (grtx_tlm, plots):
        for name, one in vars(module).items():
            if name.startswith("_") or getattr(one, "__module__", "").split(".")[0] != "grtx_tlm":
                continue
            if inspect.isfunction(one):
                yield f"{module.__name__}.{name}", one
            elif inspect.isclass(one):
                for method, function in inspect.getmembers(one, inspect.isfunction):
                    if function.__module__.startswith("grtx_tlm") and function.__qualname__.startswith(f"{name}."):
                        yield f"{name}.{method}", function


def parameters(function):
    return set(inspect.signature(function).parameters)


def options(command):
    return {option.names[-1][2:].replace("-", "_"): option for option in cli_help.command(PROGRAM, command).options}


def interpreters():
    """This Python, and each other from 3.11 on that runs."""
    found = {}
    for name in (sys.executable, "python3", *(f"python3.{minor}" for minor in range(11, 20))):
        path = shutil.which(name)
        done = path and subprocess.run([path, "-c", "import sys, venv; print(sys.executable, *sys.version_info[:2])"],
                                       capture_output=True, text=True)
        if done and done.returncode == 0:
            executable, major, minor = done.stdout.rsplit(maxsplit=2)
            if (int(major), int(minor)) >= (3, 11):
                found[os.path.realpath(executable)] = executable
    return found.values()


class Package(unittest.TestCase):
    def test_every_parameter_and_result_has_a_type(self):
        checked = 0
        for name, function in calls():
            hints = typing.get_type_hints(function)
            for parameter in inspect.signature(function).parameters.values():
                self.assertTrue(parameter.name in hints or parameter.name == "self", f"{name}: {parameter.name}")
            self.assertIn("return", hints, name)
            checked += 1
        self.assertGreater(checked, 20)
        for record in (grtx_tlm.Results, grtx_tlm.RayGroup):
            self.assertEqual(set(typing.get_type_hints(record)), set(record.__dataclass_fields__))

    def test_completion_sees_every_option_of_the_program(self):
        for name, function in calls():
            kinds = [p.kind for p in inspect.signature(function).parameters.values() if p.name != "_"]
            self.assertNotIn(inspect.Parameter.VAR_KEYWORD, kinds, name)
        sim, run = options("sim"), options("run")
        self.assertEqual(parameters(runs.simulate),
                         {"trace", "settings", "program"} | set(sim) - SHOWS - {"set", "stats"})
        self.assertEqual(parameters(runs.run), {"settings", "program"} | set(run) - SHOWS - {"set"})
        self.assertEqual(parameters(runs.simulate_all), {"traces", "settings", "values", "jobs", "program"} |
                         set(sim) - SHOWS - {"set", "stats"} - PER_RUN)
        self.assertEqual(list(typing.get_args(runs.Mode)), sim["mode"].choices)
        for function, command in ((runs.simulate, sim), (runs.run, run)):
            flags = {name for name, parameter in inspect.signature(function).parameters.items() if parameter.default is False}
            self.assertEqual(flags, {name for name in set(command) - SHOWS if not command[name].value})

    def test_an_unknown_option_is_refused_before_anything_runs(self):
        with self.assertRaisesRegex(TypeError, "'mod'"):
            grtx_tlm.simulate("t.grtx", mod="cycle", program=PROGRAM)

    def test_the_version_is_the_program_s(self):
        said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
        self.assertIn("grtx " + grtx_tlm.__version__.replace(".dev0", "-dev"), said)

    def test_wheels_build_and_install_without_a_network(self):
        wheels = set()
        for python in interpreters():
            with self.subTest(python), tempfile.TemporaryDirectory() as folder:
                def run(*command):
                    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=surroundings)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    return done.stdout.strip()
                surroundings = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PIP_"))}
                surroundings |= {"PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
                shutil.copytree(os.path.join(ROOT, "python"), os.path.join(folder, "source"),
                                ignore=shutil.ignore_patterns("__pycache__", "notebooks"))
                own = os.path.join(folder, "venv", "bin", "python")
                run(python, "-m", "venv", "--system-site-packages", "--without-pip", "venv")
                pip = (python, "-m", "pip", "--python", own)
                run(*pip, "wheel", "--no-build-isolation", "--no-deps", "-w", "wheels", "./source")
                wheel = os.path.join(folder, "wheels", f"grtx_tlm-{grtx_tlm.__version__}-py3-none-any.whl")
                run(*pip, "install", "--no-deps", wheel)
                place, version = run(own, "-c", "import importlib.util, importlib.metadata as m; "
                                     "print(importlib.util.find_spec('grtx_tlm').origin, m.version('grtx_tlm'))").split()
                self.assertTrue(place.startswith(os.path.join(folder, "venv")), place)
                self.assertEqual(version, grtx_tlm.__version__)
                self.assertTrue(os.path.exists(os.path.join(os.path.dirname(place), "py.typed")))
                run(own, "-m", "compileall", "-q", "-f", os.path.dirname(place))
                if python == sys.executable:  # has the packages that it imports
                    self.assertEqual(run(own, "-c", "import grtx_tlm.plots; print(grtx_tlm.__file__)"), place)
                    run(*pip, "install", "--no-deps", "--no-build-isolation", "--force-reinstall", "-e", "./source")
                    place = run(own, "-c", "import grtx_tlm; print(grtx_tlm.__file__)")
                    self.assertTrue(place.startswith(os.path.join(folder, "source")), place)
                with open(wheel, "rb") as file:
                    wheels.add(file.read())
        self.assertEqual(len(wheels), 1)  # the same bytes from each


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
