# What a bench prints and a test holds to, or two benches have, compiled once. Read before tests/ and bench/.
# stillpoint_shared_figures(NAME FILES pattern... [EXCEPT regex] DEPS ...)
function(stillpoint_shared_figures name)
  cmake_parse_arguments(ARG "" "EXCEPT" "FILES;DEPS" ${ARGN})
  list(TRANSFORM ARG_FILES PREPEND ${PROJECT_SOURCE_DIR}/bench/)
  file(GLOB sources CONFIGURE_DEPENDS ${ARG_FILES})
  if(ARG_EXCEPT)
    list(FILTER sources EXCLUDE REGEX ${ARG_EXCEPT})
  endif()
  add_library(${name} STATIC EXCLUDE_FROM_ALL ${sources})
  target_link_libraries(${name} PUBLIC ${ARG_DEPS} PRIVATE stillpoint_options)
  stillpoint_precompile(programs ${name})
endfunction()

configure_file(${PROJECT_SOURCE_DIR}/tests/source_folder.cpp.in ${PROJECT_BINARY_DIR}/source_folder.cpp @ONLY)
add_library(source_folder STATIC EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/source_folder.cpp)
target_link_libraries(source_folder PRIVATE stillpoint_options)

stillpoint_shared_figures(ordinary_use FILES ordinary_*.cpp DEPS sp_calib_online sp_io)
stillpoint_shared_figures(calibration_tables_parts FILES calibration_*.cpp EXCEPT "(_bench|/calibration_tables)\\.cpp$"
                          DEPS ordinary_use sp_calib_offline)
if(NOT STILLPOINT_ALGORITHMS_ONLY)
  stillpoint_shared_figures(portfolio_run FILES portfolio_run.cpp portfolio_simulated.cpp
                            DEPS sp_pipeline sp_simulation sp_io nlohmann_json::nlohmann_json fmt::fmt)
endif()
