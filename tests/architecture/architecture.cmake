# SPDX-License-Identifier: MIT
# Compares the code in the folder `source` with host/README.md: which room includes which, how long the storeys are, who
# knows the coefficients, and whether files and names on the page exist.
cmake_minimum_required(VERSION 3.22)
set(page ${source}/host/README.md)
set(code "c|comp|cpp|glsl|h|hpp|inl") # endings
set(broken "")

# Lines of the product at most: of code in host without its examples, kernels and include; and of core with include.
# Only an issue that names its lines raises a number; the commit names it and says what was removed for it.
set(most_product 42251)
set(most_core 18394)

# Members of Coefficients are named in kernels and in these files. Those with one letter are not looked for: b and f are
# names of other members too, and whoever reads all of them also reads a longer one.
set(knows_coefficients
    "^kernels/|^host/(core/model/coefficients(\\.cpp|_in\\.hpp)|lab/schedule/(baselines\\.hpp|forcing\\.cpp)|lab/planner/coefficient_errors\\.hpp)$")

macro(fault message)
    string(REPLACE ";" " " fault "${message}")
    list(APPEND broken "${fault}")
endmacro()

# A room is a folder in a storey of host (core, lab, doors), a folder beside the storeys, or one of the other two folders
# of the library.
function(room_of path result)
    string(REGEX REPLACE "^host/((core|lab|doors)/[^/]+|[^/]+).*" "\\1" room "${path}")
    string(REGEX REPLACE "^(kernels|include)/.*" "\\1" room "${room}")
    set(${result} "${room}" PARENT_SCOPE)
endfunction()

file(GLOB rooms RELATIVE ${source} ${source}/host/core/* ${source}/host/lab/* ${source}/host/doors/* ${source}/host/* ${source}/kernels
    ${source}/include)
list(FILTER rooms EXCLUDE REGEX "\\.md$|^host/(core|lab|doors)$")
list(TRANSFORM rooms REPLACE "^host/" "")
list(REMOVE_DUPLICATES rooms)
file(GLOB_RECURSE files RELATIVE ${source} ${source}/host/* ${source}/kernels/* ${source}/include/*)
list(FILTER files INCLUDE REGEX "\\.(${code})$")
list(SORT files)

# The table: | `room` | what lives there | `rooms` or files that it may include |
set(rows "")
file(STRINGS ${page} lines REGEX "^\\| `[a-z/]+` \\|[^|]*\\|[^|]*\\|$")
foreach(line IN LISTS lines)
    string(REGEX MATCH "^\\| `([a-z/]+)` \\|[^|]*\\| ([^|]*) \\|$" line "${line}")
    set(room ${CMAKE_MATCH_1})
    string(REGEX MATCHALL "[a-z]+[a-z_/.]*" allowed_${room} "${CMAKE_MATCH_2}")
    list(APPEND rows ${room})
    foreach(name IN LISTS allowed_${room})
        if(NOT name IN_LIST rooms AND NOT name IN_LIST files)
            fault("host/README.md: ${room} may include ${name}, which does not exist")
        endif()
        if("${room} ${name}" MATCHES "^core/.* (lab|doors)/|^lab/.* doors/")
            fault("host/README.md: ${room} may include ${name}, which is above it")
        endif()
    endforeach()
    if(NOT room IN_LIST rooms)
        fault("host/README.md has a row for ${room}, which is no room")
    endif()
endforeach()
foreach(room IN LISTS rooms)
    if(NOT room IN_LIST rows)
        fault("${room} has no row in host/README.md")
    endif()
endforeach()
set(lines_core 0)
file(GLOB_RECURSE product RELATIVE ${source} ${source}/host/* ${source}/kernels/* ${source}/include/*)
list(FILTER product INCLUDE REGEX "\\.(${code}|js|py)$")
list(FILTER product EXCLUDE REGEX "^host/examples/|__pycache__")
set(lines_product 0)
foreach(file IN LISTS product)
    file(READ ${source}/${file} text)
    string(REGEX REPLACE "[^\n]" "" ends "${text}")
    string(LENGTH "${ends}" length)
    math(EXPR lines_product "${lines_product} + ${length}")
    if(file MATCHES "^(host/core|include)/")
        math(EXPR lines_core "${lines_core} + ${length}")
    endif()
endforeach()

# The X-list of kernels/layout.h.
file(STRINGS ${source}/kernels/layout.h list REGEX "^ +each\\(E\\) each\\(b\\)")
string(REGEX MATCHALL "[a-z]+[a-z0-9]+\\)" coefficients "${list}")
list(JOIN coefficients "|" coefficients)
string(REPLACE ")" "" coefficients "${coefficients}")
if(NOT coefficients MATCHES "i0.*leak.*a2")
    fault("kernels/layout.h: COEFFICIENTS is not where it was")
endif()

foreach(file IN LISTS files)
    room_of(${file} room)
    get_filename_component(folder ${file} DIRECTORY)
    file(READ ${source}/${file} text)

    # What names no file of the project is of the standard library, another one's, or made by the build.
    file(STRINGS ${source}/${file} includes REGEX "^ *# *include")
    foreach(line IN LISTS includes)
        string(REGEX REPLACE "^ *# *include *[<\"]([^>\"]*).*" "\\1" path "${line}")
        if(line MATCHES "\"" AND EXISTS ${source}/${folder}/${path}) # beside this one
            get_filename_component(path ${source}/${folder}/${path} ABSOLUTE)
            file(RELATIVE_PATH path ${source} ${path})
        endif()
        string(REGEX REPLACE "^dermis/" "include/dermis/" path "${path}")
        room_of("${path}" target)
        if(room STREQUAL "kernels" AND NOT path MATCHES "^kernels/")
            fault("${file} includes ${path}: kernels include each other alone")
        elseif(file MATCHES "^host/core/" AND path MATCHES "^include/dermis/(dermis\\.h|(dermis|scene|run)\\.hpp)$")
            fault("${file} includes ${path}, which is of the laboratory")
        elseif(path MATCHES "^(host|kernels|include)/" AND NOT target STREQUAL room
               AND NOT target IN_LIST allowed_${room} AND NOT path IN_LIST allowed_${room})
            fault("${file} includes ${path}: ${room} may include: ${allowed_${room}}")
        endif()
    endforeach()

    string(REGEX REPLACE "//[^\n]*" "" text "${text}")
    if(NOT file MATCHES "${knows_coefficients}" AND text MATCHES "(\\.|->|::)(${coefficients})[^A-Za-z0-9_]")
        fault("${file}: the coefficient ${CMAKE_MATCH_2} is named outside ${knows_coefficients}")
    endif()
endforeach()

foreach(part product core)
    message(STATUS "${part}: ${lines_${part}} lines of ${most_${part}}")
    if(lines_${part} GREATER most_${part})
        fault("the ${part} has ${lines_${part}} lines, this test allows ${most_${part}}")
    endif()
endforeach()

# `file` and `file: name` on the page: there is one file whose path ends so, and the last word of the name occurs in it.
# The table of words: | `word`, `word` | meaning | `file` |
file(READ ${page} text)
string(REGEX MATCHALL "`[A-Za-z0-9_./]+\\.(${code})(: [A-Za-z0-9_:]+)?`" places "${text}")
file(STRINGS ${page} lines REGEX "^\\| `[^|]+ \\| [^|]+ \\| `[^`]+\\.[a-z]+` \\|$")
foreach(line IN LISTS lines)
    string(REGEX REPLACE ".*`([^`]+)` \\|$" "\\1" file "${line}")
    string(REGEX REPLACE "^\\| ([^|]+) .*" "\\1" words "${line}")
    string(REGEX MATCHALL "[A-Za-z_]+" words "${words}")
    list(TRANSFORM words PREPEND "`${file}: ")
    list(TRANSFORM words APPEND "`")
    list(APPEND places ${words})
endforeach()
list(REMOVE_DUPLICATES places)
foreach(place IN LISTS places)
    string(REGEX MATCH "`([^:]+)(: (.*::)?([^:]+))?`" place "${place}")
    set(name ${CMAKE_MATCH_1})
    set(word "${CMAKE_MATCH_4}")
    string(REPLACE "." "\\." pattern "(^|/)${name}$")
    set(found ${files})
    list(FILTER found INCLUDE REGEX "${pattern}")
    list(LENGTH found count)
    if(NOT count EQUAL 1)
        fault("host/README.md: ${place} is ${count} files")
        continue()
    endif()
    file(READ ${source}/${found} text)
    if(word AND NOT text MATCHES "[^A-Za-z0-9_]${word}[^A-Za-z0-9_]")
        fault("host/README.md: ${found} has no ${word}")
    endif()
endforeach()
if(NOT places)
    fault("host/README.md names no file")
endif()

if(broken)
    list(JOIN broken "\n  " broken)
    message(FATAL_ERROR "\n  ${broken}") # indented lines are not broken
endif()
