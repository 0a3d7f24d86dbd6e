# SPDX-License-Identifier: MIT
# The page in the browser, where emscripten compiles; elsewhere the program that replays recordings of the page.
add_executable(dermis-page host/examples/page/session.cpp)
target_link_libraries(dermis-page PRIVATE dermis_core_objects dermis_options)
if(NOT EMSCRIPTEN)
    target_sources(dermis-page PRIVATE host/examples/page/replay.cpp)
    set_target_properties(dermis-page PROPERTIES OUTPUT_NAME dermis-replay)
    return()
endif()

# GLM alone of the headers that this machine has for its own programs.
find_path(DERMIS_GLM glm/common.hpp REQUIRED NO_CMAKE_FIND_ROOT_PATH PATHS /usr/include)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/headers)
file(CREATE_LINK ${DERMIS_GLM}/glm ${PROJECT_BINARY_DIR}/headers/glm SYMBOLIC)
target_include_directories(dermis_options SYSTEM INTERFACE ${PROJECT_BINARY_DIR}/headers)
target_compile_options(dermis_options INTERFACE -msimd128 -fwasm-exceptions -Wno-unknown-pragmas
    -include ${PROJECT_SOURCE_DIR}/host/examples/page/old_library.hpp)

target_sources(dermis-page PRIVATE host/examples/page/page.cpp)
set(calls _page_begin _page_step _page_map _page_pressed _page_fibres _page_ending _page_spikes _page_spike_fibre _page_spike_time _page_hash)
list(JOIN calls "," calls)
target_link_options(dermis-page PRIVATE -fwasm-exceptions -sMODULARIZE=1 -sEXPORT_NAME=loadDermis -sENVIRONMENT=web
    -sALLOW_MEMORY_GROWTH=1 -sFILESYSTEM=0 -sEXPORTED_FUNCTIONS=${calls} -sEXPORTED_RUNTIME_METHODS=UTF8ToString)
# A page that was opened from a disk may load scripts, but no other file: the module is the text of a script.
set(folder ${PROJECT_BINARY_DIR}/page)
set_target_properties(dermis-page PROPERTIES OUTPUT_NAME dermis RUNTIME_OUTPUT_DIRECTORY ${folder})
add_custom_command(TARGET dermis-page POST_BUILD WORKING_DIRECTORY ${folder} VERBATIM COMMAND sh -c
    "{ printf 'const dermisWasm = \"'; gzip -9nc dermis.wasm | base64 -w0; printf '\";\\n'; } >wasm.js && rm dermis.wasm")
foreach(file index.html page.js)
    configure_file(host/examples/page/${file} ${folder}/${file} COPYONLY)
endforeach()
