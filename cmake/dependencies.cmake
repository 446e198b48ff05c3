# Everything inhabit stands on, found the same way in the build and by find_package(inhabit).
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
find_package(Torch REQUIRED)
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(nlohmann_json 3 REQUIRED)
find_package(spdlog REQUIRED)
find_package(assimp REQUIRED)
find_package(embree REQUIRED)  # 3 or 4
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(libzip REQUIRED)
find_package(Threads REQUIRED)
find_package(OpenMP REQUIRED)
find_package(BLAS REQUIRED)  # its threads are held back by nn/one_blas_thread.h

# c10d over gloo, for training in several processes; its header needs gloo's own (Debian: libgloo-dev).
find_path(INHABIT_GLOO_INCLUDE gloo/algorithm.h)
find_path(INHABIT_C10D_INCLUDE torch/csrc/distributed/c10d/ProcessGroupGloo.hpp HINTS ${TORCH_INCLUDE_DIRS})
# And NCCL between GPUs: LibTorch's header lies beside that one even where LibTorch knows no CUDA, and needs NCCL's own.
find_path(INHABIT_NCCL_INCLUDE nccl.h HINTS ${CUDA_INCLUDE_DIRS} ${CUDAToolkit_INCLUDE_DIRS})
if(TARGET torch_cuda AND INHABIT_NCCL_INCLUDE AND EXISTS "${INHABIT_C10D_INCLUDE}/torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp")
  set(INHABIT_NCCL ON)
else()
  set(INHABIT_NCCL OFF)
endif()

# LibTorch 2 from elsewhere than Debian has headers of another fmt than the one that spdlog's library was built with, and
# they would be found first: all of its headers but those, as links.
set(INHABIT_TORCH_INCLUDES ${TORCH_INCLUDE_DIRS})
foreach(folder ${TORCH_INCLUDE_DIRS})
  if(EXISTS ${folder}/fmt/core.h AND NOT folder IN_LIST CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES)
    set(links ${CMAKE_BINARY_DIR}/torch_headers)
    file(MAKE_DIRECTORY ${links})
    file(GLOB headers RELATIVE ${folder} ${folder}/*)
    list(REMOVE_ITEM headers fmt)
    foreach(header ${headers})
      file(CREATE_LINK ${folder}/${header} ${links}/${header} SYMBOLIC)
    endforeach()
    list(TRANSFORM INHABIT_TORCH_INCLUDES REPLACE "^${folder}$" "${links}")
  endif()
endforeach()

if(NOT TARGET inhabit_dependencies)
  add_library(inhabit_dependencies INTERFACE)
  target_include_directories(inhabit_dependencies SYSTEM INTERFACE "$<BUILD_INTERFACE:${INHABIT_TORCH_INCLUDES}>"
    "$<INSTALL_INTERFACE:${TORCH_INCLUDE_DIRS}>")
  target_link_libraries(inhabit_dependencies INTERFACE ${TORCH_LIBRARIES} Eigen3::Eigen
    nlohmann_json::nlohmann_json spdlog::spdlog assimp::assimp embree ZLIB::ZLIB PNG::PNG libzip::zip Threads::Threads OpenMP::OpenMP_CXX BLAS::BLAS)
endif()
