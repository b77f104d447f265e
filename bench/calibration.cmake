# The calibration's tables (paper beside ours) and its micro benchmark.
add_executable(calibration_tables calibration_tables.cpp)
target_link_libraries(calibration_tables PRIVATE stillpoint_options source_folder calibration_tables_parts ordinary_use CLI11::CLI11)

add_executable(calibration_bench calibration_bench.cpp)
target_link_libraries(calibration_bench PRIVATE stillpoint_options sp_calib_offline benchmark::benchmark)
