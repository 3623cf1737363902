# SPDX-License-Identifier: Apache-2.0
# Helpers: one library a folder, one test program a folder.

# waystone_library(NAME SOURCES ... DEPS ...): the static library waystone_NAME of the current folder.
# DEPS are what its headers need, so they are public.
function(waystone_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  set(target waystone_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC ${ARG_DEPS} PRIVATE waystone_warnings)
  if(WAYSTONE_PCH)
    target_precompile_headers(${target} REUSE_FROM waystone_pch)
  endif()
endfunction()

# waystone_test(NAME SOURCES ... DEPS ... [SECONDS n]): the test program test_NAME, one ctest entry.
function(waystone_test name)
  cmake_parse_arguments(ARG "" "SECONDS" "SOURCES;DEPS" ${ARGN})
  set(target test_${name})
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE ${ARG_DEPS} GTest::gtest_main waystone_warnings)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${target} PRIVATE WAYSTONE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(WAYSTONE_PCH)
    target_precompile_headers(${target} REUSE_FROM waystone_pch)
  endif()
  add_test(NAME ${name} COMMAND ${target})
  if(NOT ARG_SECONDS)
    set(ARG_SECONDS 120)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_SECONDS})
endfunction()
