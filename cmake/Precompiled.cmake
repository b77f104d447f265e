# What most files include and is slow to read - Eigen, fmt, the standard library, GoogleTest in the tests - is read once for
# all of them: without it that was half of a build's time. Such a header serves what is compiled with the same flags only,
# so there is one for each kind of target. Every file still includes what it uses: -DSTILLPOINT_PRECOMPILED=OFF
# -DCMAKE_UNITY_BUILD=OFF shows it.
option(STILLPOINT_PRECOMPILED "Read the headers that most files include once" ON)
set(STILLPOINT_OFTEN <Eigen/Dense> <fmt/format.h> <algorithm> <array> <chrono> <cmath> <filesystem> <functional> <map>
    <memory> <mutex> <numbers> <optional> <random> <span> <string> <string_view> <thread> <vector>)

if(STILLPOINT_PRECOMPILED AND CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # It warns falsely of std::string's `+` out of such a header.
  target_compile_options(stillpoint_options INTERFACE -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict)
endif()
# A definition that a header asks for must be the same everywhere.
target_compile_definitions(stillpoint_options INTERFACE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
file(WRITE ${PROJECT_BINARY_DIR}/precompiled.cpp "")
# stillpoint_precompiled(precompiled_tests DEPS GTest::gtest HEADERS <gtest/gtest.h>): a kind of target.
function(stillpoint_precompiled kind)
  cmake_parse_arguments(ARG "" "" "DEPS;HEADERS;OPTIONS" ${ARGN})
  add_library(${kind} OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(${kind} PRIVATE stillpoint_options Eigen3::Eigen fmt::fmt ${ARG_DEPS})
  target_compile_options(${kind} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${kind} PRIVATE ${ARG_HEADERS} ${STILLPOINT_OFTEN})
endfunction()

# stillpoint_precompile(tests TARGET...): these targets are of the kind `tests`; stillpoint_harden() makes it tests_hardened.
function(stillpoint_precompile kind)
  if(STILLPOINT_PRECOMPILED)
    set_target_properties(${ARGN} PROPERTIES PRECOMPILE_HEADERS_REUSE_FROM precompiled_${kind})
  endif()
endfunction()

set(library -fPIC -fno-semantic-interposition)
stillpoint_precompiled(precompiled_libraries OPTIONS ${library})
stillpoint_precompiled(precompiled_libraries_hardened OPTIONS ${library} ${STILLPOINT_HARDENING})
stillpoint_precompiled(precompiled_programs)
stillpoint_precompiled(precompiled_programs_hardened OPTIONS ${STILLPOINT_HARDENING})
