# SPDX-License-Identifier: Apache-2.0
"""Claims: what the paper says, what is expected of the model, and by how much it may differ."""
import os
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
HOLDS = 0.20  # of the paper's printed number
TARGETS = os.path.join(HERE, "..", "..", "report", "page", "paper_targets.toml")


class Claim:
    def __init__(self, entry, printed):
        """printed: entries with a number of the paper, by the name that `target` and `over` may have."""
        self.id, self.item, self.what, self.why = entry["id"], entry["item"], entry["what"], entry["why"]
        self.why_on = entry.get("why_on", {})  # machine: another cause there
        target = printed[entry["target"]] if "target" in entry else entry
        self.paper, self.source = target.get("paper"), entry.get("source", target["source"])
        if "over" in entry:
            self.paper /= printed[entry["over"]]["paper"]
        self.bound = target.get("at_least", False)  # the paper gives a lower bound
        self.tolerance = entry.get("tolerance", 0.03)
        self.above, self.below = entry.get("above"), entry.get("below")  # the paper's direction

    def holds(self, value):
        """Whether the paper's printed number is met: a value within HOLDS of it, a bound by a value beyond. None: no number."""
        if self.paper is None:
            return None
        return value >= self.paper if self.bound else abs(value / self.paper - 1) <= HOLDS

    def cause(self, machine):
        """Why ours differs there."""
        return self.why_on.get(machine, self.why)

    def direction(self, value):
        """Whether the paper's direction is met; None when it has none."""
        if self.above is None and self.below is None:
            return None
        return (self.above is None or value > self.above) and (self.below is None or value < self.below)


def read(path):
    with open(path, "rb") as file:
        return tomllib.load(file)


def load(path=os.path.join(HERE, "claims.toml")):
    entries = read(path)["claim"]
    printed = {t["name"]: t for kind in read(TARGETS).values() if isinstance(kind, list) for t in kind} | {entry["id"]: entry for entry in entries}
    return {entry["id"]: Claim(entry, printed) for entry in entries}


class Expected:
    """Values recorded from a run, a set and machine each: [SET.MACHINE] id = value."""

    def __init__(self, path):
        self.path = path
        self.values = read(path) if os.path.exists(path) else {}

    def of(self, which, machine, claim):
        return self.values.get(which, {}).get(machine, {}).get(claim)

    def same(self, which, machine, claim, value):
        """Whether a value is as recorded, within the claim's tolerance; None: nothing is recorded."""
        expected = self.of(which, machine, claim.id)
        return None if expected is None else abs(value - expected) <= claim.tolerance * abs(expected)

    def faults(self, which, found, claims):
        """One line for each value of found, {(claim, machine): value}, that left its tolerance, or that a set with
        recorded values lacks."""
        for (name, machine), value in sorted(found.items()):
            expected, tolerance = self.of(which, machine, name), claims[name].tolerance
            if expected is None:
                if which in self.values:
                    yield f"claim {name}, machine {machine}: {value:.4g} has no expected value (--record)"
            elif not self.same(which, machine, claims[name], value):
                yield (f"claim {name}, machine {machine}: {value:.4g} is outside {expected:.4g} ± {100 * tolerance:g} % "
                       f"(item {claims[name].item}: {claims[name].what})")

    def record(self, which, found):
        for (name, machine), value in found.items():
            self.values.setdefault(which, {}).setdefault(machine, {})[name] = value
        lines = ["# SPDX-" "License-Identifier: Apache-2.0",  # in two, else reuse takes it for this file's
                 "# What the model is expected to give: written by scripts/reproduce.sh --record, tolerances in claims.toml."]
        for a, machines in sorted(self.values.items()):
            for machine, entries in sorted(machines.items()):
                lines += ["", f"[{a}.{machine}]"] + [f"{name} = {value:.6g}" for name, value in sorted(entries.items())]
        with open(self.path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
