# SPDX-License-Identifier: MIT
# One claim about what the pages say; an error unless it holds. Variables: see CMakeLists.txt.
cmake_minimum_required(VERSION 3.22)

function(run)
    execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Each folder holds the traces of a run, and a summary by this version at some commit.
function(need_results)
    foreach(folder ${ARGN})
        if(NOT EXISTS ${folder}/traces.csv)
            message(FATAL_ERROR "no ${folder}/traces.csv")
        endif()
        file(READ ${folder}/summary.json summary)
        string(JSON made_by GET "${summary}" version)
        string(JSON commit GET "${summary}" commit)
        if(NOT made_by STREQUAL version OR commit STREQUAL "")
            message(FATAL_ERROR "${folder}/summary.json is by version ${made_by}, commit ${commit}")
        endif()
    endforeach()
endfunction()

file(REMOVE_RECURSE ${work})

# The command in the first lines of a scene runs; only its results go elsewhere. A sweep has a folder for each value.
if(claim STREQUAL "example")
    get_filename_component(name ${scene} NAME)
    file(STRINGS ${scene} command REGEX "^#     dermis run ${name} --out results")
    if(command STREQUAL "")
        message(FATAL_ERROR "no command to run it in ${scene}")
    endif()
    string(REGEX REPLACE ".*--out results" "" options "${command}")
    separate_arguments(options UNIX_COMMAND "${options}")
    run(${dermis} run ${scene} --out ${work} ${options})
    set(folders ${work})
    if(options)
        file(GLOB folders ${work}/[0-9]*)
    endif()
    if(NOT folders)
        message(FATAL_ERROR "a sweep without runs in ${work}")
    endif()
    need_results(${folders})

# The scenes in the pages run as they stand.
elseif(claim STREQUAL "scenes")
    foreach(page host/examples/README.md host/lab/scenes/README.md)
        run(${python} ${CMAKE_CURRENT_LIST_DIR}/blocks.py toml ${work}/${page} ${source}/${page})
        file(GLOB blocks ${work}/${page}/*.toml)
        foreach(block ${blocks})
            run(${dermis} run ${block} --out ${block}_results)
            need_results(${block}_results)
        endforeach()
    endforeach()

# An unknown key is refused with those that are known there: each has its line in the table of its section.
elseif(claim STREQUAL "keys")
    run(${python} ${CMAKE_CURRENT_LIST_DIR}/keys.py ${dermis} ${source}/host/lab/scenes/README.md)

# A link within the repository leads somewhere.
elseif(claim STREQUAL "links")
    run(${python} ${CMAKE_CURRENT_LIST_DIR}/links.py ${source}/README.md)

# Pictures that the command draws can be drawn by a reader.
elseif(claim STREQUAL "gallery")
    run(${python} ${CMAKE_CURRENT_LIST_DIR}/gallery.py ${dermis} ${source}/host/examples/GALLERY.md ${work} ${bench})

# The pages that name the version name this one.
elseif(claim STREQUAL "version")
    file(STRINGS ${source}/CITATION.cff cited REGEX "^version: ${version}$")
    file(STRINGS ${source}/CHANGELOG.md described REGEX "^## ${version}$")
    if(NOT cited OR NOT described)
        message(FATAL_ERROR "version ${version} is missing in CITATION.cff or CHANGELOG.md")
    endif()

else()
    message(FATAL_ERROR "no such claim: ${claim}")
endif()
