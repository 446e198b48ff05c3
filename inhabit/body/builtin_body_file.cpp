#include "inhabit/body/builtin_body_data.h"
#include "inhabit/embedded_file.h"

namespace inhabit {

INHABIT_EMBEDDED_FILE(builtin_body_file, INHABIT_BUILTIN_BODY)

}  // namespace inhabit
