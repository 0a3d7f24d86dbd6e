# SPDX-License-Identifier: MIT
# The compiled module of the Python package, with its stub. pyproject.toml sets DERMIS_PYTHON and adds the rest.
find_package(Python 3.10 REQUIRED COMPONENTS Interpreter Development.Module ${SKBUILD_SABI_COMPONENT})
find_package(nanobind 3.1 CONFIG REQUIRED)
nanobind_add_module(dermis_python STABLE_ABI NB_STATIC
    host/doors/python/afferents.cpp
    host/doors/python/contact.cpp
    host/doors/python/devices.cpp
    host/doors/python/fit.cpp
    host/doors/python/module.cpp
    host/doors/python/result.cpp
    host/doors/python/scene.cpp
    host/doors/python/skin.cpp
    host/doors/python/skin_arguments.cpp
    host/doors/python/touch.cpp)
set_target_properties(dermis_python PROPERTIES OUTPUT_NAME _core)
target_link_libraries(dermis_python PRIVATE ${dermis_objects} dermis_options)
nanobind_add_stub(dermis_python_stub
    MODULE _core
    OUTPUT ${DERMIS_GENERATED}/_core.pyi
    INCLUDE_PRIVATE
    PYTHON_PATH $<TARGET_FILE_DIR:dermis_python>
    DEPENDS dermis_python)
# Its keyword objects for the tables of a scene are written from the list of keys.
add_custom_command(OUTPUT ${DERMIS_GENERATED}/_tables.py
    COMMAND ${Python_EXECUTABLE} ${PROJECT_SOURCE_DIR}/host/doors/python/tables.py $<TARGET_FILE_DIR:dermis_python> ${DERMIS_GENERATED}/_tables.py
    DEPENDS dermis_python host/doors/python/tables.py VERBATIM)
add_custom_target(dermis_python_tables ALL DEPENDS ${DERMIS_GENERATED}/_tables.py)
install(FILES ${DERMIS_GENERATED}/_tables.py DESTINATION dermis COMPONENT python EXCLUDE_FROM_ALL)
install(TARGETS dermis_python LIBRARY DESTINATION dermis COMPONENT python EXCLUDE_FROM_ALL)
# A release has the command too, as the program `dermis` beside Python.
if(DERMIS_BUNDLED AND DERMIS_CLI)
    add_dependencies(dermis_python dermis-cli)
    install(TARGETS dermis-cli DESTINATION ${SKBUILD_SCRIPTS_DIR} COMPONENT python EXCLUDE_FROM_ALL)
    install(FILES bundled/LICENSES.txt DESTINATION ${SKBUILD_METADATA_DIR}/licenses COMPONENT python EXCLUDE_FROM_ALL)
endif()
install(FILES host/lab/command/fit.py DESTINATION dermis RENAME _fit.py COMPONENT python EXCLUDE_FROM_ALL)
install(FILES host/lab/output/plot.py DESTINATION dermis RENAME _plot.py COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${DERMIS_GENERATED}/_core.pyi DESTINATION dermis COMPONENT python EXCLUDE_FROM_ALL)
