include(CMakePackageConfigHelpers)
install(TARGETS inhabit inhabit_dependencies EXPORT inhabitTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(TARGETS inhabit_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
install(TARGETS inhabit_verbs RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/inhabit COMPONENT runtime)
# What users include; not how it is done inside: kernels, packed layers, how TinyGLTF and Embree are built in.
install(DIRECTORY inhabit DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev FILES_MATCHING PATTERN "*.h"
  REGEX "(_kernel|/fast_[a-z_]*|/inbetween/(fill_window|residual_sample)|/serve/(hub|http_session|live_session)|/(pickle_machine|pickle_globals|tiny_gltf_config|work_stages|embree|instance_pool|row_layers|vector_exp|mish|grid_conv|parallel_chunks|each_person|one_blas_thread|import_frames|simd))[.]h$" EXCLUDE)
install(DIRECTORY models DESTINATION ${CMAKE_INSTALL_DATADIR}/inhabit COMPONENT runtime FILES_MATCHING PATTERN "training" EXCLUDE PATTERN "*.safetensors" PATTERN "*.md")
install(DIRECTORY blender DESTINATION ${CMAKE_INSTALL_DATADIR}/inhabit COMPONENT runtime FILES_MATCHING PATTERN "*.py")
# The node wants the helper beside it.
install(DIRECTORY examples/ros2 DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/inhabit/examples COMPONENT runtime FILES_MATCHING PATTERN "*.py" PATTERN "__pycache__" EXCLUDE)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/inhabit RENAME copyright COMPONENT runtime)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libinhabit-dev RENAME copyright COMPONENT dev)
install(FILES ${INHABIT_HELP_DIR}/inhabit.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime)
install(FILES ${INHABIT_HELP_DIR}/inhabit.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME inhabit COMPONENT runtime)
install(FILES ${INHABIT_HELP_DIR}/_inhabit DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT runtime)
install(FILES ${INHABIT_HELP_DIR}/inhabit.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT runtime)
set(INHABIT_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/inhabit)
install(EXPORT inhabitTargets NAMESPACE inhabit:: DESTINATION ${INHABIT_CMAKE_DIR} COMPONENT dev)
configure_package_config_file(cmake/inhabitConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/inhabitConfig.cmake
  INSTALL_DESTINATION ${INHABIT_CMAKE_DIR})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/inhabitConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/inhabitConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/inhabitConfigVersion.cmake
  DESTINATION ${INHABIT_CMAKE_DIR} COMPONENT dev)
