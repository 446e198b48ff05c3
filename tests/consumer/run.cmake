# Installs the build tree BUILD to a prefix of its own, builds the project in SOURCE against it, and runs that.
# cmake -DBUILD= -DSOURCE= -DWORK= [-DGENERATOR= -DCOMPILER= -DTYPE= -DFLAGS= -DPREFIX_PATH=] -P run.cmake
include(${CMAKE_CURRENT_LIST_DIR}/../run.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=${TYPE}
  -DEXAMPLE=${SOURCE}/../../examples/kinematics.cpp -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_FLAGS=${FLAGS}" "-DCMAKE_PREFIX_PATH=${WORK}/prefix;${PREFIX_PATH}")
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer)
if(NOT text MATCHES "ankle behind the knee: (0\\.99|1\\.00)")
  message(FATAL_ERROR "unexpected output: ${text}")
endif()
run(${WORK}/prefix/bin/inhabit --version)
# Finds the program of the verbs and, from there, the models.
run(${WORK}/prefix/bin/inhabit forecast ${SOURCE}/../../examples/data/walk.npz -o ${WORK}/forecast.npz)
file(REMOVE_RECURSE ${WORK})
