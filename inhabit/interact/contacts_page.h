#pragma once
#include <vector>

#include "inhabit/interact/chair.h"
#include "inhabit/interact/live_person.h"
#include "inhabit/view/page.h"

namespace inhabit::interact {

/// Where hands are proposed to touch a chair, painted on the scene: a heap of 5 cm about each contact, for each hand
/// those of all proposals together. The page looks at `scene`, which must outlive it.
Page contacts_page(const std::vector<HandContacts>& proposed, const Chair& chair, const Scene& scene);

}  // namespace inhabit::interact
