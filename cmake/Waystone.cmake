# SPDX-License-Identifier: Apache-2.0
# Helpers: one library a folder, one test program a folder.

# All of the below.
add_custom_target(waystone_headers)

# waystone_headers(TARGET HEADER...): headers compiled once, for targets that REUSE_FROM TARGET.
function(waystone_headers target)
  add_library(${target} STATIC ${PROJECT_SOURCE_DIR}/cmake/pch.cc)
  target_include_directories(${target} SYSTEM PUBLIC ${OpenCV_INCLUDE_DIRS})
  target_link_libraries(${target} PUBLIC Eigen3::Eigen PRIVATE waystone_warnings)
  add_dependencies(waystone_headers ${target})
  if(WAYSTONE_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# Templates that several sources of a target use are compiled once for all of them: half the work.
function(waystone_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${WAYSTONE_UNITY} UNITY_BUILD_BATCH_SIZE 8)
endfunction()

# waystone_library(NAME SOURCES ... DEPS ... [HEADERS target]): the static library waystone_NAME of the
# current folder. DEPS are what its headers need, so they are public. HEADERS are the precompiled
# ones; waystone_pch where not said.
function(waystone_library name)
  cmake_parse_arguments(ARG "" "HEADERS" "SOURCES;DEPS" ${ARGN})
  set(target waystone_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC ${ARG_DEPS} PRIVATE waystone_warnings)
  if(NOT ARG_HEADERS)
    set(ARG_HEADERS waystone_pch)
  endif()
  if(WAYSTONE_PCH)
    target_precompile_headers(${target} REUSE_FROM ${ARG_HEADERS})
  endif()
  waystone_unity(${target})
endfunction()

# The test programs that the sanitizers run: short_tests are all but the LONG ones, threaded_tests are
# those of what runs on several threads.
add_custom_target(short_tests)
add_custom_target(threaded_tests)

# The ctest entries NAME_1 to NAME_n, each a share of the program's tests, into the variable `tests`.
# Where suites are given, NAME_1 has those and NAME_2 all others. Each runs by a link of its own name,
# which names its report, and has a folder for its files.
function(waystone_test_shards target name count suites tests)
  set(made "")
  foreach(shard RANGE 1 ${count})
    set(link ${CMAKE_CURRENT_BINARY_DIR}/${target}_${shard})
    set(folder ${CMAKE_CURRENT_BINARY_DIR}/tmp_${shard})
    file(MAKE_DIRECTORY ${folder})
    add_custom_command(TARGET ${target} POST_BUILD
                       COMMAND ${CMAKE_COMMAND} -E create_symlink ${target} ${link})
    add_test(NAME ${name}_${shard} COMMAND ${link})
    math(EXPR index "${shard} - 1")
    set(share GTEST_TOTAL_SHARDS=${count} GTEST_SHARD_INDEX=${index})
    if(suites)  # the second half's filter starts with a minus: all but these
      list(JOIN suites ".*:" filter)
      string(REPEAT "-" ${index} sign)
      set(share "GTEST_FILTER=${sign}${filter}.*")
    endif()
    set_property(TEST ${name}_${shard} PROPERTY ENVIRONMENT ${share}
                 TMPDIR=${folder} TEST_TMPDIR=${folder})
    list(APPEND made ${name}_${shard})
  endforeach()
  set(${tests} ${made} PARENT_SCOPE)
endfunction()

# How many times as long things may take in tests, with a sanitizer.
if(WAYSTONE_SANITIZE)
  set(WAYSTONE_SLOWDOWN 10)
else()
  set(WAYSTONE_SLOWDOWN 1)
endif()

# waystone_test(NAME SOURCES ... DEPS ... [SECONDS n] [SHARDS n | FIRST_HALF suite...] [LONG]
# [THREADED]): the test program test_NAME, one ctest entry (or one a shard, NAME_1 and so on, so that
# they run in parallel; FIRST_HALF keeps suites that share what is made once a process together) with
# the labels `program`, and `long` and `threaded` where it says so. Property tests take `rapidcheck`
# among their DEPS.
function(waystone_test name)
  cmake_parse_arguments(ARG "LONG;THREADED" "SECONDS;SHARDS" "SOURCES;DEPS;FIRST_HALF" ${ARGN})
  set(target test_${name})
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE ${ARG_DEPS} GTest::gtest_main waystone_warnings)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${target} PRIVATE WAYSTONE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_compile_options(${target} PRIVATE ${WAYSTONE_TEST_OPTIONS})
  if(WAYSTONE_PCH)
    target_precompile_headers(${target} REUSE_FROM waystone_test_pch)
  endif()
  waystone_unity(${target})
  set(labels program)
  if(ARG_LONG)
    list(APPEND labels long)
  else()
    add_dependencies(short_tests ${target})
  endif()
  if(ARG_THREADED)
    list(APPEND labels threaded)
    add_dependencies(threaded_tests ${target})
  endif()
  if(NOT ARG_SECONDS)
    set(ARG_SECONDS 120)
  endif()
  if(WAYSTONE_SANITIZE)
    math(EXPR ARG_SECONDS "${ARG_SECONDS} * 5")
  endif()
  set(tests ${name})
  if(ARG_FIRST_HALF)
    set(ARG_SHARDS 2)
  endif()
  if(ARG_SHARDS)
    waystone_test_shards(${target} ${name} ${ARG_SHARDS} "${ARG_FIRST_HALF}" tests)
  else()
    add_test(NAME ${name} COMMAND ${target})
    set(folder ${CMAKE_CURRENT_BINARY_DIR}/tmp_${name})
    file(MAKE_DIRECTORY ${folder})
    set_property(TEST ${name} PROPERTY ENVIRONMENT TMPDIR=${folder} TEST_TMPDIR=${folder})
  endif()
  # What takes longest starts first, so that nothing long is left for the end.
  set_tests_properties(${tests} PROPERTIES TIMEOUT ${ARG_SECONDS} COST ${ARG_SECONDS}
                       LABELS "${labels}")
endfunction()
