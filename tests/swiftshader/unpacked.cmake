# SPDX-License-Identifier: MIT
# The files of the second driver are there, and Vulkan's loader offers that driver. Variables: see CMakeLists.txt.
cmake_minimum_required(VERSION 3.22)
foreach(file libvk_swiftshader.so libVkLayer_khronos_validation.so)
    if(NOT EXISTS ${folder}/${file})
        message(FATAL_ERROR "no ${folder}/${file}: the tests on SwiftShader need it of Debian's package chromium-common; "
            "./run test unpacks it there, where packages can be had")
    endif()
endforeach()
execute_process(COMMAND ${dermis} devices OUTPUT_VARIABLE devices COMMAND_ERROR_IS_FATAL ANY)
message("${devices}")
if(NOT devices MATCHES "\n0: SwiftShader[^\n]*\n$")
    message(FATAL_ERROR "the devices should be SwiftShader and no other")
endif()
