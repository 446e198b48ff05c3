#pragma once
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/view/page.h"

namespace inhabit {

/// The motions of files as people of one page, each called after its file; of a file with several, numbered, and with
/// more than four, small figures. @param notes what was detected or assumed is added to it, behind the file's name.
/// Throws what read_clips throws.
std::vector<PagePerson> people_of_files(const std::vector<std::string>& paths, const ClipReadOptions& reading,
                                        Notes& notes);

/// What a page of motions is called where nobody says otherwise: the first file without its folder and extension, or
/// the scene's where there are no motions. @param scene empty: none
std::string title_of_files(const std::vector<std::string>& paths, const std::string& scene);

/// Seconds of the longest motion; 0 where there are no people.
double longest_seconds(const std::vector<PagePerson>& people);

}  // namespace inhabit
