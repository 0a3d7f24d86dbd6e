# SPDX-License-Identifier: MIT
"""Translates SPIR-V modules by SPIRV-Cross and counts what keeps their rounding. Arguments: spirv-cross, spirv-dis, modules.

A float addition, subtraction or multiplication of a kernel must not be contracted. Each one is guarded in the translation
if it stands in one of Metal's functions spvFAdd, spvFSub, spvFMul, or is a `precise` value in HLSL and GLSL. A negation is
exact however it is written. A kernel whose push constants HLSL cannot pack is not translated at all, and fails so.
"""

import re
import subprocess
import sys

LANGUAGES = {
    "MSL": (["--msl", "--msl-version", "20100"], r"(?<!T )\bspvF(?:Add|Sub|Mul)\("),
    "HLSL": (["--hlsl", "--shader-model", "60"], r"\bprecise float\d? \w+\b(?! = -\w+;)"),
    "GLSL ES": (["--es", "--version", "320"], r"\bprecise (?:highp )?(?:float|vec\d) \w+\b(?! = -\w+;)"),
}
# Neither subgroups nor another precision than that of float: a device has no choice left.
CAPABILITIES = {"Shader", "SampledBuffer"}
# Functions that do no arithmetic: of the sign, and of integers.
FUNCTIONS = {"FAbs", "SMin", "SMax"}


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}:\n{done.stderr}")
    return done.stdout


def operations(text):
    """The results of float operations of a disassembled module, after a check that no others than these can round."""
    capabilities = set(re.findall(r"OpCapability (\w+)", text))
    functions = set(re.findall(r"OpExtInst %\w+ %\w+ (\w+)", text))
    for found, allowed in ((capabilities, CAPABILITIES), (functions, FUNCTIONS)):
        if not found <= allowed:
            sys.exit(f"a kernel uses {', '.join(found - allowed)}; allowed: {', '.join(sorted(allowed))}")
    return re.findall(r"(%\w+) = OpF(?:Add|Sub|Mul) ", text)


def main(cross, disassembler, modules):
    failed = False
    print(f"{'kernel':<20} {'+ - *':>6} {'decorated':>10}" + "".join(f" {name:>8}" for name in LANGUAGES))
    for module in modules:
        text = run(disassembler, "--raw-id", module)
        found = operations(text)
        count, decorated = len(found), len(set(found) & set(re.findall(r"OpDecorate (%\w+) NoContraction", text)))
        guarded = [len(re.findall(guard, run(cross, *options, module))) for options, guard in LANGUAGES.values()]
        name = module.rsplit("/", 1)[-1].removesuffix(".spv")
        print(f"{name:<20} {count:>6} {decorated:>10}" + "".join(f" {n:>8}" for n in guarded))
        failed |= count == 0 or any(n != count for n in [decorated, *guarded])
    if failed or not modules:
        sys.exit("an operation is not guarded: all numbers of a kernel should be the same")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
