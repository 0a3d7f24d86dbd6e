# SPDX-License-Identifier: MIT
# Writes MODULE, a file of SPIR-V, to HEADER as the C array `NAME`, and fails unless every float addition, subtraction,
# multiplication and negation in it is decorated NoContraction, and unless there is no float division: only then does the
# standard oblige a device to give the CPU's bits. A vector times a scalar fails too, because SPIRV-Cross forgets that
# decoration on it.
execute_process(COMMAND ${DISASSEMBLER} --raw-id ${MODULE} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "%[0-9]+ = Op(FAdd|FSub|FMul|FNegate|FDiv|FRem|FMod|VectorTimesScalar|Dot|MatrixTimes[A-Za-z]+)" arithmetic "${text}")
foreach(line ${arithmetic})
    string(REGEX MATCH "%[0-9]+" id "${line}")
    if(line MATCHES "FDiv|FRem|FMod|VectorTimesScalar|Dot|Matrix")
        message(FATAL_ERROR "${MODULE}: ${line}: kernels add, subtract and multiply factors of one type alone")
    elseif(NOT text MATCHES "OpDecorate ${id} NoContraction")
        message(FATAL_ERROR "${MODULE}: ${line} may be contracted: give its result a `precise` local")
    endif()
endforeach()

file(READ ${MODULE} words HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${words}") # the least byte of a word comes first
file(WRITE ${HEADER} "#pragma once\n#include <cstdint>\ninline constexpr uint32_t ${NAME}[] = {\n${words}};\n")
