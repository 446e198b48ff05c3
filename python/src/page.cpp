#include "inhabit/view/page.h"

#include <algorithm>

#include "calls.h"
#include "inhabit/anticipate/anticipation_page.h"
#include "inhabit/error.h"
#include "inhabit/forecast/forecast_page.h"
#include "inhabit/inbetween/inbetween_page.h"
#include "inhabit/interact/contacts_page.h"
#include "inhabit/interact/interaction_page.h"
#include "inhabit/interact/label_tracks.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/reconstruct/reconstruction_page.h"
#include "inhabit/refine/refine_depth.h"
#include "inhabit/view/cards_page.h"
#include "inhabit/view/file_cards.h"
#include "inhabit/view/file_people.h"
#include "inhabit/view/page_template.h"
#include "inhabit/view/refined_page.h"
#include "results.h"

namespace inhabit::python {
namespace {

/// A page's text, ready.
struct PageText {
  std::string html;
};

/// The page in a frame of its own, as notebooks show it: quotes and ampersands of its text escaped.
std::string framed(const std::string& html) {
  std::string text;
  text.reserve(html.size() + html.size() / 16);
  for (const char c : html) {
    if (c == '&')
      text += "&amp;";
    else if (c == '"')
      text += "&quot;";
    else
      text += c;
  }
  return "<iframe srcdoc=\"" + text + "\" style=\"width:100%;height:600px;border:0\" allowfullscreen></iframe>";
}

/// What a page is made of, which the page looks at while it is written.
struct Shown {
  Page page;
  Scene scene;
};

Page page_of_clips(const std::vector<Clip>& clips, const std::vector<std::string>& names) {
  Page page;
  for (size_t i = 0; i < clips.size(); ++i) {
    PagePerson person;
    person.name = i < names.size() ? names[i] : "motion " + std::to_string(i + 1);
    person.clip = retarget_if_known(clips[i], person.name);
    person.tracks = interact::label_tracks(person.clip);
    page.people.push_back(std::move(person));
  }
  return page;
}

/// What pages say of themselves.
struct Words {
  std::optional<std::string> title, note;
  std::vector<std::string> names;
};

/// The page of files that `inhabit view` writes, or of cards.
std::string page_of_files(const std::vector<std::string>& paths, const ClipReadOptions& reading,
                          const std::optional<Scene>& scene, const Words& words, Notes& notes) {
  if (std::any_of(paths.begin(), paths.end(), is_shown_as_cards)) {
    if (scene) throw Error("scene", "is for motions, not for a page of cards");
    CardsPage page;
    std::vector<std::string> skipped;
    page.cards = cards_of(paths, reading, notes, skipped);
    page.title = words.title.value_or(cards_title(paths));
    page.note = words.note.value_or("");
    notes.insert(notes.end(), skipped.begin(), skipped.end());
    return page_text(page, "page");
  }
  Page page;
  page.people = people_of_files(paths, reading, notes);
  for (size_t i = 0; i < page.people.size(); ++i) {
    PagePerson& person = page.people[i];
    person.tracks = interact::label_tracks(person.clip);
    if (i < words.names.size()) person.name = words.names[i];
  }
  if (scene) page.scene = &*scene;
  page.title = words.title.value_or(title_of_files(paths, scene ? scene->name : ""));
  page.note = words.note.value_or("");
  return page_text(page, "page", page_template());
}

bool is_path(const py::handle& thing) { return py::isinstance<py::str>(thing) || py::hasattr(thing, "__fspath__"); }

/// Each system's result has a page of its own; clips and files, and several of them, are shown as `inhabit view` does.
PageText make_page(const py::args& things, const std::optional<Scene>& scene, const Words& words,
                   const ClipReadOptions& reading) {
  py::list all;
  for (const py::handle thing : things) {
    if (py::isinstance<py::list>(thing) || py::isinstance<py::tuple>(thing))
      for (const py::handle one : thing.cast<py::sequence>()) all.append(one);
    else
      all.append(thing);
  }
  if (things.empty() && !scene)
    return {released([&] { return empty_page_text(words.title.value_or(""), words.note.value_or("")); })};
  if (all.empty() && !scene) throw Error("page", "is of nothing: the list is empty");
  if (!all.empty() && std::all_of(all.begin(), all.end(), is_path)) {
    const std::vector<std::string> paths = texts_of(all.cast<std::vector<Path>>());
    Notes notes;
    PageText out = {released([&] { return page_of_files(paths, reading, scene, words, notes); })};
    say(notes);
    return out;
  }
  Shown out;
  const auto results_of = [&](auto kind, std::vector<decltype(kind)>& results) {
    for (const py::handle thing : all) {
      if (!py::isinstance<decltype(kind)>(thing)) return false;
      results.push_back(thing.cast<decltype(kind)>());
    }
    return !results.empty();
  };
  std::vector<forecast::Result> forecasts;
  std::vector<anticipate::Result> futures;
  std::vector<InbetweenResult> filled;
  std::vector<InteractResult> seated;
  std::vector<RefineResult> refined;
  std::vector<refine::DepthResult> fitted;
  std::vector<reconstruct::Result> reconstructed;
  std::vector<IntentionsResult> labelled;
  std::vector<Clip> clips;
  std::vector<inbetween::Result> inner;
  std::vector<interact::Result> inner_seated;
  const auto alone = [](size_t count) {
    if (count > 1) throw Error("page", "shows one result of this kind");
  };
  if (results_of(forecast::Result(), forecasts)) {
    alone(forecasts.size());
    out.page = forecast::forecast_page(forecasts[0], "Forecast");
  } else if (results_of(anticipate::Result(), futures)) {
    alone(futures.size());
    out.page = anticipate::anticipation_page(futures[0], "Futures");
  } else if (results_of(InbetweenResult(), filled)) {
    for (const InbetweenResult& r : filled) inner.push_back(r.result);
    out.page = inbetween::inbetween_page(inner, filled[0].cleaned, filled[0].key_groups, "In-betweening");
  } else if (results_of(InteractResult(), seated)) {
    for (const InteractResult& r : seated) inner_seated.push_back(r.result);
    out.page = interact::interaction_page(inner_seated, seated[0].scene);
  } else if (results_of(RefineResult(), refined)) {
    alone(refined.size());
    out.page = refined_page({{refined[0].result.before, refined[0].result.clip}}, refined[0].scene, "Refined");
  } else if (results_of(refine::DepthResult(), fitted)) {
    alone(fitted.size());
    out.page = refined_page({{fitted[0].before, fitted[0].clip}}, out.scene, "Refined");
  } else if (results_of(reconstruct::Result(), reconstructed)) {
    alone(reconstructed.size());
    out.page = reconstruct::reconstruction_page(reconstructed[0], "a video");
  } else if (results_of(IntentionsResult(), labelled)) {
    alone(labelled.size());
    out.page = intention_page(labelled[0].set);
  } else if (all.empty() || results_of(Clip(), clips)) {
    out.page = page_of_clips(clips, words.names);
    out.page.title = words.names.empty() ? "inhabit" : words.names.front();
  } else {
    throw Error("page", "shows clips, files, or results of one kind");
  }
  if (scene) {
    out.scene = *scene;
    out.page.scene = &out.scene;
  }
  if (words.title) out.page.title = *words.title;
  if (words.note) out.page.note = *words.note;
  return {released([&] { return page_text(out.page, "page", page_template()); })};
}

PageText make_contacts_page(const std::vector<HandPoints>& contacts, const interact::Chair& chair, const Scene& scene) {
  const auto vector_of = [](const std::optional<Point>& p) {
    return p ? std::optional(Eigen::Vector3d((*p)[0], (*p)[1], (*p)[2])) : std::nullopt;
  };
  std::vector<interact::HandContacts> proposed;
  for (const auto& [left, right] : contacts) proposed.push_back({vector_of(left), vector_of(right)});
  return {
      released([&] { return page_text(interact::contacts_page(proposed, chair, scene), "page", page_template()); })};
}

}  // namespace

void add_page(py::module_& m) {
  py::class_<PageText>(m, "Page", "A self-contained page that shows motion; a notebook shows it by itself.")
      .def_readonly("html", &PageText::html, "The page's text, which needs no other file and no network.")
      .def(
          "write",
          [](const PageText& page, const Path& path) { released([&] { write_atomically(path.string(), page.html); }); },
          "path"_a, "Writes it to an .html file.")
      .def(
          "_repr_html_", [](const PageText& page) { return framed(page.html); }, "The page in a frame, for notebooks.")
      .def("__repr__",
           [](const PageText& page) { return "<inhabit.Page: " + std::to_string(page.html.size() / 1024) + " KiB>"; });
  m.def(
      "page",
      [](const py::args& things, const std::optional<Scene>& scene, const std::optional<std::string>& title,
         const std::optional<std::string>& note, const std::vector<std::string>& names,
         const std::optional<std::string>& up, std::optional<double> scale, std::optional<double> rate,
         const std::optional<Path>& asf, bool level) {
        return make_page(things, scene, {title, note, names}, reading_of(up, scale, rate, asf, level));
      },
      "scene"_a = py::none(), "title"_a = py::none(), "note"_a = py::none(), "names"_a = std::vector<std::string>(),
      "up"_a = py::none(), "scale"_a = py::none(), "rate"_a = py::none(), "asf"_a = py::none(), "level"_a = false,
      "A Page of clips, of motion files, or of what Forecaster, Anticipator, Inbetweener, Interactor, refine, "
      "reconstruct or\n"
      "intentions returned (several of Inbetweener or Interactor are samples). Folders, training logs (.jsonl) and "
      "tables\n"
      "(.json) are a card each, as `inhabit view` shows them; of nothing, a page that files are dropped on.\n"
      "scene: shown with them; results know their own. names: of the people. up, scale, rate, asf, level: how files "
      "are\n"
      "read, as read_clip has them.");
  m.def("contacts_page", make_contacts_page, "contacts"_a, "chair"_a, "scene"_a,
        "A Page of where hands are proposed to touch a chair, painted on its scene: pairs (left, right), as\n"
        "Interactor.draw_contacts gives them.");
}

}  // namespace inhabit::python
