#include <algorithm>
#include <cstdio>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/interact/label_tracks.h"
#include "inhabit/io/extension.h"
#include "inhabit/view/file_cards.h"
#include "inhabit/view/file_people.h"
#include "inputs.h"
#include "verbs.h"

namespace {

struct ViewArguments {
  std::vector<std::string> motions;
  std::string out = "page.html", title, note;
  inhabit::ClipReadOptions reading;
  SceneInput scene;
};

void write_cards(const ViewArguments& given, const std::vector<std::string>& paths) {
  if (!given.scene.file.empty()) throw inhabit::Error("--scene", "is for motions, not for a page of cards");
  inhabit::Notes notes;
  inhabit::CardsPage page;
  inhabit::FileCount count;
  page.cards = inhabit::cards_of(paths, given.reading, notes, count.skipped);
  count.done = static_cast<int64_t>(page.cards.size());
  page.title = given.title.empty() ? inhabit::cards_title(paths) : given.title;
  page.note = given.note;
  inhabit::write_page(given.out, page);
  say(notes);
  std::printf("%s: %zu card%s\n", given.out.c_str(), page.cards.size(), page.cards.size() == 1 ? "" : "s");
  end_of(count);
}

}  // namespace

void add_view(CLI::App& app) {
  auto options = std::make_shared<ViewArguments>();
  CLI::App* verb = app.add_subcommand("view", "Write a page that shows motions, and the scene they are in");
  verb->add_option(
      "motions", options->motions,
      "Motion files; none: a page that others are dropped on. Or folders, training logs (.jsonl), and what "
      "`eval --json` and `score --json` write, a card each");
  add_reading(*verb, options->reading, "the motions");
  add_scene(*verb, options->scene);
  verb->add_option("-o,--out", options->out, "The page (page.html)");
  verb->add_option("--title", options->title, "Title (the first motion's name)");
  verb->add_option("--note", options->note, "Caption below the title");
  verb->callback([options] {
    if (inhabit::extension_of(options->out) != "html")
      throw inhabit::Error(options->out, "is no name of a page: .html");
    const std::vector<std::string>& motions = options->motions;
    if (std::any_of(motions.begin(), motions.end(), inhabit::is_shown_as_cards)) return write_cards(*options, motions);
    if (motions.empty() && options->scene.file.empty()) {
      inhabit::write_empty_page(options->out, options->title, options->note);
      std::printf("%s: empty, to drop files on\n", options->out.c_str());
      return;
    }
    inhabit::Notes notes;
    inhabit::Page page;
    page.people = inhabit::people_of_files(motions, options->reading, notes);
    const inhabit::Scene scene = read_scene(options->scene, notes);
    if (!options->scene.file.empty()) page.scene = &scene;
    for (inhabit::PagePerson& person : page.people) person.tracks = inhabit::interact::label_tracks(person.clip);
    page.title = options->title.empty() ? inhabit::title_of_files(motions, scene.name) : options->title;
    page.note = options->note;
    inhabit::write_page(options->out, page);
    say(notes);
    if (page.people.empty()) {
      std::printf("%s: a scene\n", options->out.c_str());
      return;
    }
    std::printf("%s: %zu motion%s, %.1f s\n", options->out.c_str(), page.people.size(),
                page.people.size() == 1 ? "" : "s", inhabit::longest_seconds(page.people));
  });
}
