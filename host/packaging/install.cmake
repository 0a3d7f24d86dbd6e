# SPDX-License-Identifier: MIT
# The libraries with their headers, for CMake, and the whole one for pkg-config; both find it wherever the prefix is moved to. The command
# is installed where it is built. Pages and what they link to keep their folders, so that links lead somewhere; a copy of
# the sources inside another project may lack them.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/dermis)

# A program in C links them to a static library; g++ does so unasked.
set(cxx_runtime ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
list(REMOVE_ITEM cxx_runtime ${CMAKE_C_IMPLICIT_LINK_LIBRARIES})
get_target_property(kind dermis_library TYPE)
if(kind STREQUAL "STATIC_LIBRARY")
    target_link_libraries(dermis_library INTERFACE "$<$<LINK_LANGUAGE:C>:${cxx_runtime}>")
endif()
list(TRANSFORM cxx_runtime PREPEND -l)
list(JOIN cxx_runtime " " cxx_runtime)

install(TARGETS dermis_core dermis_library EXPORT dermis INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(DERMIS_CLI)
    install(TARGETS dermis-cli)
endif()
file(GLOB documents LIST_DIRECTORIES false RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS *.md CITATION.cff LICENSE bench/*.md bench/*.png bench/evidence/*
    host/*.md host/study/*
    host/core/description/*.md host/examples/* host/lab/scenes/*.md kernels/*.md tests/*.md tests/shims/*.md
    tests/embedding/frames/frames.cpp tests/embedding/mujoco/*)
foreach(document IN LISTS documents)
    get_filename_component(folder ${document} DIRECTORY)
    install(FILES ${document} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder})
endforeach()
set(absent)
if(NOT DERMIS_VULKAN)
    set(absent PATTERN vulkan.hpp EXCLUDE)
endif()
install(DIRECTORY include/dermis DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${absent})
install(EXPORT dermis NAMESPACE dermis:: FILE dermisTargets.cmake DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/dermisConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES host/packaging/dermisConfig.cmake ${PROJECT_BINARY_DIR}/dermisConfigVersion.cmake DESTINATION ${package})

file(RELATIVE_PATH includedir ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_FULL_INCLUDEDIR})
configure_file(host/packaging/dermis.pc.in ${PROJECT_BINARY_DIR}/dermis.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/dermis.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
