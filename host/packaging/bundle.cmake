# SPDX-License-Identifier: MIT
# Writes the folder bundled/ of ${source}, with which g++ and CMake alone build dermis (DERMIS_BUNDLED): the compiled
# kernels of ${generated}, the headers of other projects that dermis includes, with their licences, and the ${commit}.
# ${compiler} lists the headers, and Debian's packages have the licences.
cmake_minimum_required(VERSION 3.22)
set(bundled ${source}/bundled)
file(REMOVE_RECURSE ${bundled})
file(GLOB kernels ${generated}/*_spv.h)
file(COPY ${kernels} DESTINATION ${bundled}/generated)
file(CONFIGURE OUTPUT ${bundled}/commit.h CONTENT "#define DERMIS_COMMIT \"@commit@\"\n" @ONLY)

file(WRITE ${generated}/includes.cpp "#include \"host/core/simd/model.hpp\"
#include \"host/lab/scenes/toml.hpp\"
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <kissfft/kissfft.hh>
#include <nlohmann/json.hpp>
#include <stb/stb_image.h>
#define VOLK_IMPLEMENTATION
#include <volk.h>
")
execute_process(COMMAND ${compiler} -std=c++20 -DFMT_HEADER_ONLY -M -I${source} ${generated}/includes.cpp
    OUTPUT_VARIABLE headers COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[ \\\n]+" ";" headers "${headers}")
list(FILTER headers INCLUDE REGEX "/((glm|vulkan|vk_video|toml\\+\\+|fmt|CLI|kissfft|nlohmann|stb)/|volk\\.[ch]$)")
foreach(header IN LISTS headers)
    string(REGEX REPLACE "^.*/((glm|vulkan|vk_video|toml\\+\\+|fmt|CLI|kissfft|nlohmann|stb)/.*|volk\\.[ch])$" "\\1" name "${header}")
    configure_file(${header} ${bundled}/include/${name} COPYONLY)
endforeach()

foreach(package libglm-dev libvulkan-dev libvulkan-volk-dev libtomlplusplus-dev libfmt-dev libcli11-dev libkissfft-dev libstb-dev nlohmann-json3-dev)
    file(READ /usr/share/doc/${package}/copyright licence)
    file(APPEND ${bundled}/LICENSES.txt "${package}, parts of which dermis includes:\n\n${licence}\n\n")
endforeach()
