# SPDX-License-Identifier: MIT
# The plugin of MuJoCo, with all of the library in it and nothing of MuJoCo. Structs differ between versions of MuJoCo, so
# that the plugin's name says for which one it was built.
file(GLOB mujoco_library ${DERMIS_MUJOCO}/libmujoco.so.* ${DERMIS_MUJOCO}/lib/libmujoco.so.*)
if(NOT EXISTS ${DERMIS_MUJOCO}/include/mujoco/mjplugin.h OR NOT mujoco_library MATCHES "so\\.([0-9.]+)$")
    message(FATAL_ERROR "DERMIS_MUJOCO = ${DERMIS_MUJOCO}; allowed: a folder with include/mujoco/mjplugin.h and libmujoco.so.<version>, as MuJoCo's Python package and its archives have them")
endif()
set(mujoco_version ${CMAKE_MATCH_1})
add_library(dermis_mujoco MODULE host/doors/mujoco/plugin.cpp)
target_include_directories(dermis_mujoco SYSTEM PRIVATE ${DERMIS_MUJOCO}/include)
target_link_libraries(dermis_mujoco PRIVATE ${dermis_objects} dermis_options ${mujoco_library})
# Whoever loads the plugin has loaded that library, and the linker finds it by its name.
set_target_properties(dermis_mujoco PROPERTIES PREFIX "" OUTPUT_NAME dermis_mujoco-${mujoco_version}
    CXX_VISIBILITY_PRESET hidden SKIP_BUILD_RPATH ON UNITY_BUILD OFF)
if(TARGET dermis_python)
    add_dependencies(dermis_python dermis_mujoco) # a wheel is made of what dermis_python needs
endif()
install(TARGETS dermis_mujoco LIBRARY DESTINATION dermis COMPONENT python EXCLUDE_FROM_ALL)
if(DERMIS_INSTALL)
    include(GNUInstallDirs)
    install(TARGETS dermis_mujoco LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/dermis)
endif()
