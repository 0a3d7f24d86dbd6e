# SPDX-License-Identifier: MIT
# volk defines vkCreateBuffer and 600 more as variables. In a static library they would collide with a host that links
# Vulkan itself or has its own volk, so a generated header puts dermis_ before each name.
if(DERMIS_BUNDLED)
    set(DERMIS_VOLK ${PROJECT_SOURCE_DIR}/bundled/include)
else()
    find_path(DERMIS_VOLK volk.h REQUIRED)
endif()
file(STRINGS ${DERMIS_VOLK}/volk.h lines REGEX "^extern PFN_vk|^[A-Za-z].* volk[A-Z][A-Za-z]*\\(")
set(names "")
foreach(line ${lines})
    string(REGEX MATCH "(vk|volk)[A-Z][A-Za-z0-9]*[;(]" name "${line}")
    string(REGEX REPLACE "[;(]" "" name "${name}")
    if(line MATCHES "^extern PFN_vk([A-Za-z0-9]+) ")
        set(name vk${CMAKE_MATCH_1})
    endif()
    string(APPEND names "#define ${name} dermis_${name}\n")
endforeach()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/volk_names.h CONTENT "${names}" @ONLY)
