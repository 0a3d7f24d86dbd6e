# SPDX-License-Identifier: MIT
# Writes the header ${header} with the commit of ${source}, only where it changes. Sources that lie inside another
# repository, or in none, have the commit "unknown". Behind that, and behind "-dirty", stands a hash of the sources, so
# that equal commits mean equal sources.
cmake_minimum_required(VERSION 3.22)
if(EXISTS ${source}/bundled/commit.h) # a released archive knows its commit
    configure_file(${source}/bundled/commit.h ${header} COPYONLY)
    return()
endif()
unset(ENV{GIT_DIR}) # set in git's hooks, it would name the repository in place of the folder
set(git git --no-optional-locks -C ${source})
execute_process(COMMAND ${git} rev-parse --show-toplevel OUTPUT_VARIABLE top RESULT_VARIABLE failed
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
set(commit unknown)
if(NOT failed)
    file(REAL_PATH ${source} source)
    file(REAL_PATH "${top}" top)
endif()
if(NOT failed AND top STREQUAL source)
    execute_process(COMMAND ${git} describe --always --dirty --abbrev=12 --exclude=* OUTPUT_VARIABLE described
        RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT failed)
        set(commit ${described})
    endif()
endif()
if(commit MATCHES "unknown|-dirty")
    file(GLOB_RECURSE files RELATIVE ${source} ${source}/host/* ${source}/include/* ${source}/kernels/*)
    list(FILTER files INCLUDE REGEX "\\.(c|comp|cpp|glsl|h|hpp|inl)$")
    set(hashes "")
    foreach(file IN LISTS files ITEMS CMakeLists.txt)
        file(SHA256 ${source}/${file} hash)
        string(APPEND hashes "${file} ${hash}\n")
    endforeach()
    string(SHA256 hash "${hashes}")
    string(SUBSTRING ${hash} 0 12 hash)
    string(APPEND commit "-${hash}")
endif()
file(CONFIGURE OUTPUT ${header} CONTENT "#define DERMIS_COMMIT \"@commit@\"\n" @ONLY)
