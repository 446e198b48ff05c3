#pragma once

namespace inhabit {

/// From now on memory that is freed stays with the process, to be used again. A training step allocates and frees the
/// same hundreds of megabytes: given back to the system each time, every page would be cleared and mapped anew at the
/// next step. Only glibc knows how; elsewhere nothing happens.
void keep_freed_memory();

}  // namespace inhabit
