# SPDX-License-Identifier: MIT
# Fails unless every float addition, subtraction, multiplication and negation of MODULE is decorated NoContraction, and
# unless there is no float division: only then does the standard oblige a device to give the CPU's bits. A vector times a
# scalar fails too, because SPIRV-Cross forgets that decoration on it.
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
