# SPDX-License-Identifier: MIT
# Compares what `library` exports beside the C++ interface, and the numbers that the program `numbers` prints, with the
# file `list`. The list grows; a line of it that changes or goes breaks every program that was built before.
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND ${nm} -D --defined-only ${library} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${numbers} OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
list(FILTER symbols EXCLUDE REGEX " [TVW] _Z(N|NK|TIN|TSN|TVN)6dermis")
list(TRANSFORM symbols REPLACE "^[0-9a-f]* +(. )" "\\1")
list(SORT symbols)
list(JOIN symbols "\n" found)
string(APPEND found "\n${printed}")
file(READ ${list} expected)
if(NOT found STREQUAL expected)
    message(FATAL_ERROR "${list} has\n${expected}\nbut the library has\n${found}")
endif()
