# Warnings as an interface target; errors with -DBS_CAR_ODOMETRY_WERROR=ON (continuous integration).
option(BS_CAR_ODOMETRY_WERROR "Treat compiler warnings as errors" OFF)
add_library(bs_car_odometry_warnings INTERFACE)
target_compile_options(bs_car_odometry_warnings INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Wpedantic $<$<BOOL:${BS_CAR_ODOMETRY_WERROR}>:-Werror>)

# Sanitisers, in one place: -DBS_CAR_ODOMETRY_SANITIZE=address,undefined
set(BS_CAR_ODOMETRY_SANITIZE "" CACHE STRING "Sanitisers to build everything with, comma separated")
if(BS_CAR_ODOMETRY_SANITIZE)
  add_compile_options(-fsanitize=${BS_CAR_ODOMETRY_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${BS_CAR_ODOMETRY_SANITIZE})
endif()
