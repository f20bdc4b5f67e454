# Headers that nearly every file includes, compiled once: reading them is a third of the compile time of a sanitized
# file, and more of a test's. The released library and program go without, so that a file which forgets an include does
# not compile there; tests have them in every build.
#   abbe_precompiled(target)        a stage or the program
#   abbe_precompiled(target TESTS)  a test program

set(abbe_headers_std <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory>
    <numbers> <numeric> <optional> <random> <set> <span> <sstream> <string> <string_view> <utility> <variant> <vector>
    <Eigen/Core> <Eigen/Geometry> <fmt/format.h>)
set(abbe_headers_tests ${abbe_headers_std} <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp>)

function(abbe_precompiled target)
  set(kind std)
  set(libraries "")
  if("TESTS" IN_LIST ARGN)
    set(kind tests)
    set(libraries GTest::gtest GTest::gmock nlohmann_json::nlohmann_json)
    # One set of options serves all test programs, or headers could not be precompiled for all.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  elseif(NOT ABBE_SANITIZE)
    return()
  endif()
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  set(holder abbe_headers_${kind})
  if(NOT TARGET ${holder})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${holder}.cpp CONTENT "")
    add_library(${holder} OBJECT ${PROJECT_BINARY_DIR}/${holder}.cpp)
    target_link_libraries(${holder} PRIVATE abbe_options Eigen3::Eigen fmt::fmt ${libraries})
    target_precompile_headers(${holder} PRIVATE ${abbe_headers_${kind}})
    set_target_properties(${holder} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${holder})
endfunction()
