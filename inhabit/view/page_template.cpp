#include "inhabit/view/page_template.h"

#include "inhabit/embedded_file.h"

namespace inhabit {

INHABIT_EMBEDDED_FILE(page_template, INHABIT_PAGE_TEMPLATE)

}  // namespace inhabit
