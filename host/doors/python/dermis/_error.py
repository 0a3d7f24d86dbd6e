# SPDX-License-Identifier: MIT
"""The exceptions of the package."""


class Error(Exception):
    """A call was refused, or failed. The text names the parameter, its value and the allowed range.

    code: "bad_input" (a parameter is not allowed: an InputError), "no_device" (no device can compute), "device" (a device
    failed while working) or "io" (a file could not be written).
    Where memory cannot be allocated, Python's MemoryError says what needed how much.
    parameter: the dotted name of the parameter at fault, as in "time.step"; "" if there is none.
    """

    def __init__(self, code: str, parameter: str, message: str) -> None:
        super().__init__(code, parameter, message)
        self.code = code
        self.parameter = parameter

    def __str__(self) -> str:
        return str(self.args[2])


class InputError(Error, ValueError):
    """A parameter of a call, or a key of a scene, is not allowed: code is "bad_input"."""
