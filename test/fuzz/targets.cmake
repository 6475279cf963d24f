# The fuzz targets, built with the other tests where clang has libFuzzer.
find_program(CLANGXX clang++)
set(trial ${CMAKE_CURRENT_BINARY_DIR}/fuzz_trial)
file(WRITE ${trial}.cpp "extern \"C\" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }\n")
execute_process(COMMAND ${CLANGXX} -fsanitize=address,fuzzer ${trial}.cpp -o ${trial}
  RESULT_VARIABLE no_fuzzer OUTPUT_QUIET ERROR_QUIET)
if(no_fuzzer)
  message(STATUS "clang with libFuzzer not found: no fuzz targets")
  return()
endif()

include(ExternalProject)
externalproject_add(fuzz_targets
  PREFIX ${CMAKE_CURRENT_BINARY_DIR}/fuzz
  SOURCE_DIR ${CMAKE_CURRENT_SOURCE_DIR}/fuzz
  BINARY_DIR ${CMAKE_BINARY_DIR}/fuzz
  CMAKE_ARGS -DCMAKE_CXX_COMPILER=${CLANGXX} -DMESSAGES=${CATKIN_DEVEL_PREFIX}/include
    -DPYTHON_EXECUTABLE=${PYTHON_EXECUTABLE}
  BUILD_ALWAYS ON
  INSTALL_COMMAND ""
  EXCLUDE_FROM_ALL ON
  DEPENDS ${PROJECT_NAME}_generate_messages_cpp)
add_dependencies(tests fuzz_targets)
set(fuzz_targets fuzz_targets)
