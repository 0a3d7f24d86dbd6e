# SPDX-License-Identifier: MIT
# Compiles GLSL to SPIR-V and to C arrays at build time. Each module is optimised, because lavapipe takes ten times as long
# to compile what glslang writes; then it is validated, and checked for arithmetic that may be contracted.
set(DERMIS_GENERATED ${PROJECT_BINARY_DIR}/generated)
file(MAKE_DIRECTORY ${DERMIS_GENERATED})

# Finds a program, or names the package that Debian has it in.
function(dermis_tool variable program package)
    find_program(${variable} ${program})
    if(NOT ${variable})
        message(FATAL_ERROR "${program} is missing, which Debian has in the package ${package}; a released archive of "
            "dermis has its kernels compiled and needs none")
    endif()
endfunction()

# Compiles source.comp to generated/<kernel>_spv.h and sets `header` to that path; further arguments go to the compiler.
function(dermis_kernel source kernel header)
    set(module ${DERMIS_GENERATED}/${kernel}.spv)
    set(made ${DERMIS_GENERATED}/${kernel}_spv.h)
    add_custom_command(
        OUTPUT ${module} ${made} # the depfile names the first
        COMMAND ${DERMIS_GLSLANG} -V --quiet --target-env vulkan1.1 -I${PROJECT_SOURCE_DIR}/kernels ${ARGN} --depfile ${module}.d -o ${module} ${source}
        COMMAND ${DERMIS_SPIRV_OPT} -O ${module} -o ${module}
        COMMAND ${DERMIS_SPIRV_VAL} --target-env vulkan1.1 ${module}
        COMMAND ${CMAKE_COMMAND} -DDISASSEMBLER=${DERMIS_SPIRV_DIS} -DMODULE=${module} -DHEADER=${made} -DNAME=${kernel}_spv
            -P ${PROJECT_SOURCE_DIR}/kernels/module.cmake
        DEPENDS ${source} ${PROJECT_SOURCE_DIR}/kernels/module.cmake
        DEPFILE ${module}.d
        COMMENT "Kernel ${kernel}"
        VERBATIM)
    set(${header} ${made} PARENT_SCOPE)
endfunction()

if(DERMIS_BUNDLED)
    file(GLOB DERMIS_KERNELS ${PROJECT_SOURCE_DIR}/bundled/generated/*_spv.h)
    file(COPY ${DERMIS_KERNELS} DESTINATION ${DERMIS_GENERATED})
elseif(DERMIS_VULKAN)
    dermis_tool(DERMIS_GLSLANG glslangValidator glslang-tools)
    dermis_tool(DERMIS_SPIRV_OPT spirv-opt spirv-tools)
    dermis_tool(DERMIS_SPIRV_VAL spirv-val spirv-tools)
    dermis_tool(DERMIS_SPIRV_DIS spirv-dis spirv-tools)
    set(DERMIS_KERNELS)
    foreach(kernel press halve spread reduce fibres)
        dermis_kernel(${PROJECT_SOURCE_DIR}/kernels/${kernel}.comp ${kernel} made)
        list(APPEND DERMIS_KERNELS ${made})
    endforeach()
    foreach(variant signals sites)
        string(TOUPPER ${variant} defined)
        dermis_kernel(${PROJECT_SOURCE_DIR}/kernels/press.comp press_${variant} made -D${defined})
        list(APPEND DERMIS_KERNELS ${made})
        dermis_kernel(${PROJECT_SOURCE_DIR}/kernels/press.comp press_${variant}_texels made -D${defined} -DTEXELS)
        list(APPEND DERMIS_KERNELS ${made})
    endforeach()
    foreach(kernel press halve spread reduce)
        dermis_kernel(${PROJECT_SOURCE_DIR}/kernels/${kernel}.comp ${kernel}_texels made -DTEXELS)
        list(APPEND DERMIS_KERNELS ${made})
    endforeach()
endif()

# Writes a text file as the C++ raw string `name` into generated/<name>.h.
function(dermis_embed_text file name)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(READ ${file} text)
    file(CONFIGURE OUTPUT ${DERMIS_GENERATED}/${name}.h CONTENT
        "#pragma once\ninline constexpr char ${name}[] = R\"embedded(@text@)embedded\";\n" @ONLY)
endfunction()
