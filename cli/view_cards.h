#pragma once
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/view/cards_page.h"

/// Whether an input of `view` is shown as cards: a folder, a training's log (.jsonl) or an evaluation's table (.json).
bool is_shown_as_cards(const std::string& path);

/// All motions of a file, on the standard body where their skeleton can be mapped to it, as they are (bare skeletons)
/// otherwise.
std::vector<inhabit::Clip> read_for_view(const std::string& path, const inhabit::ClipReadOptions& reading,
                                         inhabit::Notes& notes);

/// A card for each file: of a folder for all in it that can be shown, its others being skipped and said in `notes`; of
/// a native data set for its clips in their scenes. Throws Error for a file that is named and cannot be read, and for a
/// folder without anything to show.
std::vector<inhabit::PageCard> cards_of(const std::vector<std::string>& paths, const inhabit::ClipReadOptions& reading,
                                        inhabit::Notes& notes);
