# Compiler options, the two helpers every folder uses, and ccache where it is installed.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")  # our own SP_EXPECTS stays on in every build

find_program(CCACHE ccache)
if(CCACHE)
  # The sloppiness is what ccache asks for before it keeps a file that was compiled with a precompiled header. Paths count
  # from the project's root: what one checkout has compiled one by one (CMAKE_UNITY_BUILD=OFF) serves the others.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
      CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
endif()

# CMAKE_UNITY_BUILD, which the presets switch on, compiles eight sources of a folder as one: what they instantiate of Eigen
# and the standard library is instantiated once, and a build takes half the time. Names in unnamed namespaces of one library
# must differ then; "redefinition" means: rename it. Whoever edits one file over and over is faster with
# -DCMAKE_UNITY_BUILD=OFF, and where a compiler has less than 1.5 GB it must be.
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  set(subobject_linkage -Wno-subobject-linkage)  # an Impl that holds types of its own .cpp looks like one of a header
endif()

find_package(Threads REQUIRED)
include(Install)

add_library(stillpoint_options INTERFACE)
target_compile_options(stillpoint_options INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow ${subobject_linkage})
if(NOT STILLPOINT_SANITIZE)  # gcc 12 warns falsely of what sanitizers add
  target_compile_options(stillpoint_options INTERFACE -Werror)
endif()
target_include_directories(stillpoint_options INTERFACE ${PROJECT_SOURCE_DIR})
if(STILLPOINT_SANITIZE)
  # vptr reads an object through a pipe: with no file left to open (a fault that is tested) every object looks invalid.
  # null and alignment are checked at every access, a third of the compilation: only where strangers' bytes are read
  # (Hardening.cmake); elsewhere a null pointer still ends the program.
  add_compile_options(-fsanitize=${STILLPOINT_SANITIZE} -fno-sanitize=vptr,null,alignment -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${STILLPOINT_SANITIZE})
endif()
if(STILLPOINT_LIBFUZZER)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

include(Hardening)
include(Precompiled)

# stillpoint_library(core DEPS ...): every .cpp of the calling folder and below; header-only folders become INTERFACE libraries.
# FILES pattern takes only those files, EXCEPT regex leaves some out: io/ holds two libraries, one of them without DDS.
function(stillpoint_library name)
  cmake_parse_arguments(ARG "" "FILES;EXCEPT" "DEPS" ${ARGN})
  if(NOT ARG_FILES)
    set(ARG_FILES *.cpp)
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${ARG_FILES})
  if(ARG_EXCEPT)
    list(FILTER sources EXCLUDE REGEX ${ARG_EXCEPT})
  endif()
  if(sources)
    add_library(sp_${name} STATIC ${sources})
    target_link_libraries(sp_${name} PUBLIC ${ARG_DEPS} PRIVATE $<BUILD_INTERFACE:stillpoint_options>)
    set(reach PUBLIC)
    # One compilation serves the programs, the shared libraries and the Python module; our own functions stay inlined.
    set_target_properties(sp_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_options(sp_${name} PRIVATE -fno-semantic-interposition)
    stillpoint_precompile(libraries sp_${name})
  else()
    add_library(sp_${name} INTERFACE)
    target_link_libraries(sp_${name} INTERFACE ${ARG_DEPS})
    set(reach INTERFACE)
  endif()
  target_compile_features(sp_${name} ${reach} cxx_std_20)
  target_include_directories(sp_${name} ${reach} $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  stillpoint_install(${name} ${ARG_DEPS})
endfunction()

# stillpoint_embed(TARGET NAMESPACE FILE...): the files' text is part of the program, in arrays named after the files.
function(stillpoint_embed target namespace)
  set(made ${CMAKE_CURRENT_BINARY_DIR}/${target}_embedded.cpp)
  add_custom_command(OUTPUT ${made}
                     COMMAND ${CMAKE_COMMAND} -DOUT=${made} -DNAMESPACE=${namespace} "-DIN=${ARGN}" -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
                     DEPENDS ${ARGN} ${PROJECT_SOURCE_DIR}/cmake/embed.cmake VERBATIM)
  target_sources(${target} PRIVATE ${made})
endfunction()

set(STILLPOINT_TEST_TIMEOUT_S 300)
if(STILLPOINT_SANITIZE OR CMAKE_CROSSCOMPILING)
  set(STILLPOINT_TEST_TIMEOUT_S 1500)  # the searches of diagnosis/ take some ten times as long under AddressSanitizer or qemu
endif()

# stillpoint_tests(core DEPS ...): tests/core/*_test.cpp is one program, each TEST one CTest entry.
# tests/core/long/*_test.cpp is a second one with the label "long" (proofs that take minutes).
function(stillpoint_tests folder)
  cmake_parse_arguments(ARG "" "" "DEPS" ${ARGN})
  foreach(kind "" "long")
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/${kind}/*_test.cpp)
    if(NOT sources OR (kind STREQUAL "long" AND STILLPOINT_SANITIZE))  # proofs of figures; too slow under sanitizers
      continue()
    endif()
    if(kind STREQUAL "long")
      set(target test_${folder}_long)
      set(properties LABELS long TIMEOUT 1800)
    else()
      set(target test_${folder})
      set(properties LABELS ${folder} TIMEOUT ${STILLPOINT_TEST_TIMEOUT_S})
    endif()
    add_executable(${target} ${sources})
    target_link_libraries(${target} PRIVATE stillpoint_options ${ARG_DEPS} source_folder GTest::gmock GTest::gtest_main)
    stillpoint_precompile(tests ${target})
    gtest_discover_tests(${target} TEST_PREFIX ${folder}. PROPERTIES ${properties} DISCOVERY_TIMEOUT 120)
  endforeach()
endfunction()
