# cmake -DVERILATOR=program -DFOLDER=folder -DPREFIX=name -DRISE=0|1 -DTOGETHER=0|1 -P verilate.cmake --
#   OPTION... SOURCE...
#
# Verilates a model, class `name`, into the folder. Verilator writes a dozen files a model, other ones in each version,
# and each reads the same headers. So the code that runs often is joined in one source (`often` in
# its name), and the rest in another (`seldom`); with TOGETHER all of it in the first. With RISE the first one also
# defines rise() (sim/board/verilated_rise.h).
#
# Paths are given to Verilator relative to the project, because some versions read no source in a path with a space.
cmake_policy(VERSION 3.25)
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH root)
set(words "")
set(last "")
math(EXPR end "${CMAKE_ARGC} - 1")
foreach(i RANGE ${end})
  set(word "${CMAKE_ARGV${i}}")
  if(words OR last STREQUAL "--")
    if(IS_ABSOLUTE "${word}")
      file(RELATIVE_PATH word "${root}" "${word}")
    endif()
    list(APPEND words "${word}")
  endif()
  set(last "${word}")
endforeach()

file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
file(RELATIVE_PATH relative "${root}" "${FOLDER}")
execute_process(COMMAND "${VERILATOR}" --cc --Mdir "${relative}" --prefix ${PREFIX} ${words}
  WORKING_DIRECTORY "${root}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

file(GLOB often RELATIVE "${FOLDER}" "${FOLDER}/*.cpp")
set(seldom ${often})
list(FILTER seldom INCLUDE REGEX "__Syms|__ConstPool|Slow[.]cpp$")
list(REMOVE_ITEM often ${seldom})
foreach(kind IN ITEMS often seldom)
  list(TRANSFORM ${kind} REPLACE "^(.+)$" "#include \"\\1\"\n")
  list(JOIN ${kind} "" ${kind})
endforeach()
if(TOGETHER)
  string(APPEND often "${seldom}")
else()
  file(WRITE "${FOLDER}/${PREFIX}__seldom.cpp" "${seldom}")
endif()
if(RISE)
  string(APPEND often "#define SELFPROJ_MODEL ${PREFIX}\n#define SELFPROJ_PART(name) ${PREFIX}___024root___##name\n"
    "#include \"sim/board/verilated_rise.h\"\n")
endif()
file(WRITE "${FOLDER}/${PREFIX}__often.cpp" "${often}")
