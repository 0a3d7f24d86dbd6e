# SPDX-License-Identifier: MIT
# One claim about what a stranger's project gets; an error unless it holds. Variables: see CMakeLists.txt.
cmake_minimum_required(VERSION 3.22)
set(here ${CMAKE_CURRENT_LIST_DIR})
set(prefix ${work}/prefix_${kind})

function(run)
    execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(configure project folder)
    run(${CMAKE_COMMAND} -S ${here}/${project} -B ${folder} -G ${generator} -DCMAKE_BUILD_TYPE=${build_type}
        -DCMAKE_C_COMPILER=${cc} -DCMAKE_CXX_COMPILER=${cxx} -DCMAKE_C_FLAGS=${c_flags} -DCMAKE_CXX_FLAGS=${cxx_flags}
        ${ARGN})
endfunction()

function(lines result)
    execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE "[\r\n]+" ";" text "${text}")
    set(${result} "${text}" PARENT_SCOPE)
endfunction()

# The program ends well and prints a text that matches `expected`.
function(printed expected)
    execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE text COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
    message("${text}")
    if(NOT text MATCHES "${expected}")
        message(FATAL_ERROR "nothing in it matches ${expected}")
    endif()
endfunction()

# `program` prints what a plain program on the library built here prints.
function(same_bits program)
    lines(expected ${work}/package_${built}/bits)
    lines(actual ${program})
    message("${actual}")
    if(NOT actual STREQUAL expected)
        message(FATAL_ERROR "other bits than\n${expected}")
    endif()
endfunction()

# Moved after installation: nothing installed knows where it was put.
if(claim STREQUAL "install")
    file(REMOVE_RECURSE ${prefix} ${prefix}_first)
    run(${CMAKE_COMMAND} --install ${build} --prefix ${prefix}_first)
    file(RENAME ${prefix}_first ${prefix})

# With only what the library is made of, which must stay as it is, and no header of what command and tests use. Another
# optimization than here, and several files in one unit: a parent project may set both, and neither may change a bit.
elseif(claim STREQUAL "add_subdirectory")
    set(parts CMakeLists.txt host include kernels)
    set(copy ${work}/source)
    file(REMOVE_RECURSE ${copy} ${prefix})
    foreach(part ${parts})
        file(COPY ${source}/${part} DESTINATION ${copy})
    endforeach()
    foreach(header CLI/CLI.hpp fmt/format.h doctest/doctest.h)
        file(WRITE ${work}/poison/${header} "#error a library needs no ${header}\n")
    endforeach()
    set(ENV{CPATH} ${work}/poison)
    set(shared OFF)
    if(kind STREQUAL "shared")
        set(shared ON)
    endif()
    set(folder ${work}/subproject)
    configure(subproject ${folder} -Ddermis_source=${copy} -DBUILD_SHARED_LIBS=${shared}
        -DCMAKE_UNITY_BUILD=ON "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG" -UDERMIS_*)
    run(${CMAKE_COMMAND} --install ${folder} --prefix ${prefix})
    if(EXISTS ${prefix})
        message(FATAL_ERROR "a part of another project installs itself unasked")
    endif()
    configure(subproject ${folder} -DDERMIS_INSTALL=ON)
    run(${CMAKE_COMMAND} --build ${folder})
    run(${CMAKE_COMMAND} --install ${folder} --prefix ${prefix})
    file(GLOB names RELATIVE ${copy} ${copy}/*)
    if(NOT names STREQUAL parts)
        message(FATAL_ERROR "the source tree has become: ${names}")
    endif()
    foreach(part ${parts})
        run(diff -r ${source}/${part} ${copy}/${part})
    endforeach()
    same_bits(${folder}/bits)
    # a copy inside another repository does not take that one's commit for its own
    file(STRINGS ${folder}/dermis/generated/commit.h commit)
    if(NOT commit STREQUAL "#define DERMIS_COMMIT \"unknown\"")
        message(FATAL_ERROR "a copy of the sources has the ${commit}")
    endif()

# The command, which runs, the licence and the README are installed beside the library.
elseif(claim STREQUAL "command")
    foreach(file bin/dermis share/doc/dermis/LICENSE share/doc/dermis/README.md)
        if(NOT EXISTS ${prefix}/${file})
            message(FATAL_ERROR "no ${prefix}/${file}")
        endif()
    endforeach()
    printed("^dermis ${version} \\(commit [^)]+\\)\n$" ${prefix}/bin/dermis --version)

# The example programs are a stranger's project too.
elseif(claim STREQUAL "examples")
    set(folder ${work}/examples)
    configure(../../host/examples ${folder} -DCMAKE_PREFIX_PATH=${prefix}
        "-DCMAKE_CXX_FLAGS=${cxx_flags} -Wall -Wextra -pedantic -Werror")
    run(${CMAKE_COMMAND} --build ${folder})
    printed("dermis ${version}: 500 times by the model moments in f64\n"
        ${folder}/run_scene ${source}/host/examples/first_press.toml)
    printed("frame 60: greatest SA1 [0-9.]+, greatest FA1 [0-9.]+\n" ${folder}/frame_by_frame)
    printed("^100 ms: 0.5 N on [0-9]+ cells, at most 1.89e\\+04 Pa; greatest FA1 [0-9.]+\n200 ms: 0.5 N" ${folder}/contacts)
    printed("^275 receptors\n 40 ms:  sa1 of 100 receptors, mean [0-9.]+" ${folder}/receptors)

# The C++ of README.md compiles without a warning and runs.
elseif(claim STREQUAL "readme")
    set(folder ${work}/readme)
    file(REMOVE_RECURSE ${folder})
    run(${python} ${here}/../documents/blocks.py cpp ${folder} ${source}/README.md)
    configure(blocks ${folder}/build -Dfolder=${folder} -DCMAKE_PREFIX_PATH=${prefix})
    run(${CMAKE_COMMAND} --build ${folder}/build)
    file(GLOB programs ${folder}/*.cpp)
    foreach(program ${programs})
        get_filename_component(name ${program} NAME_WE)
        printed("[0-9]" ${folder}/build/${name})
    endforeach()

elseif(claim STREQUAL "find_package")
    configure(package ${work}/package_${kind} -DCMAKE_PREFIX_PATH=${prefix} -Dversion=${version})
    run(${CMAKE_COMMAND} --build ${work}/package_${kind})
    same_bits(${work}/package_${kind}/bits)

elseif(claim STREQUAL "fast_math")
    same_bits(${work}/package_${kind}/fast_math)

elseif(claim STREQUAL "pkg_config")
    file(GLOB_RECURSE pc ${prefix}/dermis.pc)
    get_filename_component(folder ${pc} DIRECTORY)
    set(ENV{PKG_CONFIG_PATH} ${folder})
    set(ENV{LD_LIBRARY_PATH} ${folder}/..)
    set(static)
    if(kind STREQUAL "static")
        set(static --static)
    endif()
    run(${pkg_config} --exact-version=${version} dermis)
    execute_process(COMMAND ${pkg_config} --cflags --libs ${static} dermis OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags UNIX_COMMAND "${cxx_flags} ${here}/package/bits.cpp ${flags}")
    run(${cxx} -std=c++17 ${flags} -o ${work}/pkg_config_${kind})
    same_bits(${work}/pkg_config_${kind})

# Each header by itself, strictly.
elseif(claim STREQUAL "cxx17")
    file(GLOB headers RELATIVE ${prefix}/include ${prefix}/include/dermis/*)
    if(NOT "dermis/dermis.hpp" IN_LIST headers)
        message(FATAL_ERROR "no headers in ${prefix}/include")
    endif()
    separate_arguments(flags UNIX_COMMAND "${cxx_flags}")
    foreach(header ${headers})
        file(WRITE ${work}/cxx17.cpp "#include <${header}>\n")
        run(${cxx} ${flags} -std=c++17 -pedantic-errors -Wall -Wextra -Werror -I${prefix}/include -fsyntax-only
            ${work}/cxx17.cpp)
    endforeach()

# A shared library shows what the headers declare, a static one has no name of Vulkan's or volk's.
elseif(claim STREQUAL "symbols")
    if(kind STREQUAL "shared")
        file(GLOB_RECURSE library ${prefix}/libdermis.so)
        lines(symbols ${nm} -D --defined-only ${library})
        set(foreign ${symbols})
        list(FILTER foreign EXCLUDE REGEX " [TVW] _Z(N|NK|TIN|TSN|TVN)6dermis")
        # Namespaces have the names of the folders, as the test `architecture` sees to; dermis::vulkan is public.
        file(GLOB namespaces RELATIVE ${source}/host ${source}/host/*)
        list(FILTER namespaces EXCLUDE REGEX "\\.|^vulkan$")
        list(JOIN namespaces "|" namespaces)
        lines(internal ${nm} -DC --defined-only ${library}) # not mangled, where a namespace may be a substitution
        list(FILTER internal INCLUDE REGEX "dermis::(${namespaces}|kernels)::|::(Impl|Internal)::")
        lines(needed ${objdump} -p ${library})
        list(FILTER needed INCLUDE REGEX "NEEDED +lib(vulkan|fmt|tomlplusplus)")
        list(APPEND foreign ${internal} ${needed})
    else()
        file(GLOB_RECURSE library ${prefix}/libdermis.a)
        lines(symbols ${nm} -g --defined-only ${library})
        set(foreign ${symbols})
        list(FILTER foreign INCLUDE REGEX " (vk|volk)[A-Za-z]")
    endif()
    if(NOT symbols MATCHES " T _ZN6dermis3runE")
        message(FATAL_ERROR "no dermis::run in ${library}")
    elseif(foreign)
        list(JOIN foreign "\n" foreign)
        message(FATAL_ERROR "in ${library}:\n${foreign}")
    endif()

elseif(claim STREQUAL "frames")
    configure(../embedding/frames ${work}/frames -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_COMPILE_WARNING_AS_ERROR=ON)
    run(${CMAKE_COMMAND} --build ${work}/frames)

else()
    message(FATAL_ERROR "no such claim: ${claim}")
endif()
