#pragma once
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/view/cards_page.h"

namespace inhabit {

/// Whether files are shown as cards and not in one view in 3D: a folder, a training's log (.jsonl) or an evaluation's
/// table (.json). Throws Error(path, ...) for a .json file that is no JSON.
bool is_shown_as_cards(const std::string& path);

/// All motions of a file as pages show them (retarget_if_known). @param notes what was detected or assumed is added to
/// it, behind the file's name. Throws what read_clips throws.
std::vector<Clip> read_for_view(const std::string& path, const ClipReadOptions& reading, Notes& notes);

/// What a page of cards is called where nobody says otherwise: "walk.bvh", "recordings and 2 more".
std::string cards_title(const std::vector<std::string>& paths);

/// A card for each file: of a folder for all in it that can be shown, at most 200; of a native data set for its
/// clips in their scenes. Throws Error for a file that is named and cannot be read, and for a folder without anything
/// to show. @param skipped why files of folders are left out is added to it, a line for each
std::vector<PageCard> cards_of(const std::vector<std::string>& paths, const ClipReadOptions& reading, Notes& notes,
                               std::vector<std::string>& skipped);

}  // namespace inhabit
