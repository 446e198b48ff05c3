#pragma once

/// The version of the library, the command, the Python module and the packages; the build reads it from here.
#define INHABIT_VERSION "0.1.0"
