# SPDX-License-Identifier: MIT
"""Which of some instructions a run of a program executes; gdb reads this: gdb -batch -x reached.py --args PROGRAM ARGUMENTS

REACHED holds "OUT ADDRESS ..", addresses as in the program's file. Those that were executed are written to the file OUT,
a line each, if the program ends with status 0.
"""

import os
from pathlib import Path

import gdb

out, *addresses = os.environ["REACHED"].split()
for command in ["set pagination off", "set confirm off", "set breakpoint pending off", "set print thread-events off",
                "set print inferior-events off", "handle all nostop noprint pass", "handle SIGTRAP stop noprint nopass", "starti"]:
    gdb.execute(command, to_string=True)
program = gdb.selected_inferior().pid
maps = Path(f"/proc/{program}/maps").read_text().splitlines()
base = int(next(line for line in maps if line.endswith(gdb.current_progspace().filename)).split("-")[0], 16)
waiting = {base + int(address): gdb.Breakpoint(f"*{base + int(address):#x}") for address in addresses}
executed = []
while True:
    gdb.execute("continue", to_string=True)
    if not gdb.selected_inferior().pid:
        break
    here = gdb.selected_frame().pc()
    if here in waiting:  # each one stops the program once
        waiting.pop(here).delete()
        executed.append(here - base)
if int(gdb.parse_and_eval("$_exitcode")) == 0:
    Path(out).write_text("".join(f"{address}\n" for address in executed))
