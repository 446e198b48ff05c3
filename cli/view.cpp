#include "inhabit/view/page.h"

#include <cstdio>
#include <filesystem>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/interact/label_tracks.h"
#include "inhabit/io/extension.h"
#include "inhabit/motion/retarget.h"
#include "inputs.h"
#include "verbs.h"

namespace {

struct ViewArguments {
  std::vector<std::string> motions;
  std::string out = "page.html", title, note;
  inhabit::ClipReadOptions reading;
  SceneInput scene;
};

/// The motion on the standard body where its skeleton can be mapped to it, as it is (a bare skeleton) otherwise.
inhabit::Clip read_for_view(const std::string& path, const inhabit::ClipReadOptions& reading, inhabit::Notes& notes) {
  const inhabit::Clip clip = read_motion(path, reading, notes);
  try {
    return inhabit::retarget(clip, path);
  } catch (const inhabit::Error&) {
    return clip;
  }
}

}  // namespace

void add_view(CLI::App& app) {
  auto options = std::make_shared<ViewArguments>();
  CLI::App* verb = app.add_subcommand("view", "Write a page that shows motions, and the scene they are in");
  verb->add_option("motions", options->motions, "Motion files")->required();
  add_reading(*verb, options->reading, "the motions");
  add_scene(*verb, options->scene);
  verb->add_option("-o,--out", options->out, "The page (page.html)");
  verb->add_option("--title", options->title, "Title (the first motion's name)");
  verb->add_option("--note", options->note, "Caption below the title");
  verb->callback([options] {
    if (inhabit::extension_of(options->out) != "html")
      throw inhabit::Error(options->out, "is no name of a page: .html");
    inhabit::Notes notes;
    inhabit::Page page;
    for (const std::string& path : options->motions) {
      inhabit::PagePerson person;
      person.clip = read_for_view(path, options->reading, notes);
      person.name = std::filesystem::path(path).stem().string();
      page.people.push_back(std::move(person));
    }
    const inhabit::Scene scene = read_scene(options->scene, notes);
    if (!options->scene.file.empty()) page.scene = &scene;
    for (inhabit::PagePerson& person : page.people) person.tracks = inhabit::interact::label_tracks(person.clip);
    page.title = options->title.empty() ? page.people.front().name : options->title;
    page.note = options->note;
    inhabit::write_page(options->out, page);
    say(notes);
    double longest = 0;
    for (const inhabit::PagePerson& person : page.people) longest = std::max(longest, person.clip.seconds());
    std::printf("%s: %zu motion%s, %.1f s\n", options->out.c_str(), page.people.size(),
                page.people.size() == 1 ? "" : "s", longest);
  });
}
