# Headers that nearly every file includes, compiled once for the sanitized build: reading them is a third of its compile
# time. The released build goes without, so that a file which forgets an include does not compile there.
#   abbe_precompiled(target)        a stage or the program
#   abbe_precompiled(target TESTS)  a test program

set(abbe_headers_std <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory>
    <numbers> <numeric> <optional> <random> <set> <span> <sstream> <string> <string_view> <utility> <variant> <vector>
    <Eigen/Core> <Eigen/Geometry> <fmt/format.h>)
set(abbe_headers_tests ${abbe_headers_std} <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp>)

function(abbe_precompiled target)
  if(NOT ABBE_SANITIZE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  set(kind std)
  set(libraries "")
  if("TESTS" IN_LIST ARGN)
    set(kind tests)
    set(libraries GTest::gtest GTest::gmock nlohmann_json::nlohmann_json)
  endif()
  set(holder abbe_headers_${kind})
  if(NOT TARGET ${holder})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${holder}.cpp CONTENT "")
    add_library(${holder} OBJECT ${PROJECT_BINARY_DIR}/${holder}.cpp)
    target_link_libraries(${holder} PRIVATE abbe_options Eigen3::Eigen fmt::fmt ${libraries})
    target_precompile_headers(${holder} PRIVATE ${abbe_headers_${kind}})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${holder})
endfunction()
