# SPDX-License-Identifier: Apache-2.0
"""What holds since injected faults found that it did not: inject_faults_test.py PROGRAM LIBRARY"""
import os
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import inject_faults  # noqa: E402

PROGRAM = inject_faults.Program(*map(os.path.abspath, sys.argv[1:3]))


class Symptoms(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = os.path.realpath(tempfile.mkdtemp())
        cls.inputs = cls.top + "/inputs"
        inject_faults.make_inputs(PROGRAM, cls.inputs)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.top)

    def end_of(self, name, what, number):
        """(outcome, what is wrong) of a command whose call fails."""
        command = inject_faults.commands_of([name])[0]
        folder = f"{self.top}/{name}"
        if not os.path.exists(folder):
            command.prepare(PROGRAM, self.inputs, folder)
            setattr(self.__class__, name, command)
        command = getattr(self, name)
        command.fresh(folder)
        injector = inject_faults.Injector(PROGRAM, folder)
        injector.arm(inject_faults.CLASSES.index(what), number)
        code, errors = PROGRAM.run(command.arguments, folder, injector.environment())
        fired = injector.read()[0]
        self.assertEqual(fired, 1, f"{name}: {what} {number} was not reached")
        return command.judge(PROGRAM, folder, what, code, errors, fired)

    def hold(self, name, what, numbers):
        for number in numbers:
            with self.subTest(command=name, what=what, number=number):
                outcome, wrong = self.end_of(name, what, number)
                self.assertEqual(wrong, "")
                self.assertNotEqual(outcome, "")

    def test_a_report_does_not_blame_the_machine_for_a_process_that_cannot_be_started(self):
        self.hold("report", "start_process", [1, 2])

    def test_without_memory_it_ends_in_one_line(self):
        self.hold("synth", "allocate", range(1, 41))

    def test_the_first_line_of_a_waveform_on_a_full_disk_is_no_internal_error(self):
        self.hold("sim", "write", [1])

    def test_a_repeated_sweep_describes_statistics_as_an_undisturbed_one(self):
        self.hold("sweep", "rename", [4])

    def test_an_open_that_fails_is_what_the_state_file_says(self):
        """The library does what these tests believe."""
        outcome, wrong = self.end_of("trace", "open_write", 1)
        self.assertEqual((outcome, wrong), ("exit 2, old", ""))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
