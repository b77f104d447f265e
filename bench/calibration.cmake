# The calibration's tables (paper beside ours) and its micro benchmark.
file(GLOB calibration_parts CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/calibration_*.cpp)
list(FILTER calibration_parts EXCLUDE REGEX "_bench\\.cpp$")
file(GLOB ordinary_use CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/ordinary_*.cpp)
add_executable(calibration_tables ${calibration_parts} ${ordinary_use})
target_link_libraries(calibration_tables PRIVATE stillpoint_options sp_calib_online sp_io CLI11::CLI11)
target_compile_definitions(calibration_tables PRIVATE STILLPOINT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

add_executable(calibration_bench calibration_bench.cpp)
target_link_libraries(calibration_bench PRIVATE stillpoint_options sp_calib_online benchmark::benchmark)
