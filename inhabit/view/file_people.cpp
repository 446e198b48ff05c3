#include "inhabit/view/file_people.h"

#include <algorithm>
#include <filesystem>

#include "inhabit/view/file_cards.h"

namespace inhabit {
namespace {

constexpr size_t kBodies = 4;  // of a file with more motions small figures are shown

std::string stem_of(const std::string& path) { return std::filesystem::path(path).stem().string(); }

}  // namespace

std::vector<PagePerson> people_of_files(const std::vector<std::string>& paths, const ClipReadOptions& reading,
                                        Notes& notes) {
  std::vector<PagePerson> people;
  for (const std::string& path : paths) {
    std::vector<Clip> clips = read_for_view(path, reading, notes);
    for (size_t k = 0; k < clips.size(); ++k) {
      PagePerson& person = people.emplace_back();
      person.clip = std::move(clips[k]);
      person.name = stem_of(path);
      if (clips.size() > 1) person.name += " " + std::to_string(k);
      if (clips.size() > kBodies) person.role = PagePerson::Role::future;
    }
  }
  return people;
}

std::string title_of_files(const std::vector<std::string>& paths, const std::string& scene) {
  return stem_of(paths.empty() ? scene : paths.front());
}

double longest_seconds(const std::vector<PagePerson>& people) {
  double longest = 0;
  for (const PagePerson& person : people) longest = std::max(longest, person.clip.seconds());
  return longest;
}

}  // namespace inhabit
