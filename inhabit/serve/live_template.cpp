#include "inhabit/serve/live_template.h"

#include "inhabit/embedded_file.h"

namespace inhabit {

INHABIT_EMBEDDED_FILE(live_template, INHABIT_LIVE_TEMPLATE)

}  // namespace inhabit
