include(CMakePackageConfigHelpers)
install(TARGETS inhabit inhabit_dependencies EXPORT inhabitTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS inhabit_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS inhabit_verbs RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/inhabit)
# What users include; not how it is done inside: kernels, packed layers, how TinyGLTF and Embree are built in.
install(DIRECTORY inhabit DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h"
  REGEX "(_kernel|/fast_[a-z_]*|/inbetween/(fill_window|residual_sample)|/serve/(hub|http_session|live_session)|/(tiny_gltf_config|work_stages|embree|instance_pool|row_layers|vector_exp|mish|grid_conv|parallel_chunks|simd))[.]h$" EXCLUDE)
install(DIRECTORY models DESTINATION ${CMAKE_INSTALL_DATADIR}/inhabit FILES_MATCHING PATTERN "training" EXCLUDE PATTERN "*.safetensors" PATTERN "*.md")
set(INHABIT_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/inhabit)
install(EXPORT inhabitTargets NAMESPACE inhabit:: DESTINATION ${INHABIT_CMAKE_DIR})
configure_package_config_file(cmake/inhabitConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/inhabitConfig.cmake
  INSTALL_DESTINATION ${INHABIT_CMAKE_DIR})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/inhabitConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/inhabitConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/inhabitConfigVersion.cmake
  DESTINATION ${INHABIT_CMAKE_DIR})
