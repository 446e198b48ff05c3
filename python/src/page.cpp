#include "inhabit/view/page.h"

#include "calls.h"
#include "inhabit/anticipate/anticipation_page.h"
#include "inhabit/error.h"
#include "inhabit/forecast/forecast_page.h"
#include "inhabit/inbetween/inbetween_page.h"
#include "inhabit/interact/interaction_page.h"
#include "inhabit/interact/label_tracks.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/reconstruct/reconstruction_page.h"
#include "inhabit/refine/refine_depth.h"
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

/// Each system's result has a page of its own; clips, and several of them, are shown as `inhabit view` does.
PageText make_page(const py::args& things, const std::optional<Scene>& scene, const std::optional<std::string>& title,
                   const std::optional<std::string>& note, const std::vector<std::string>& names) {
  if (things.empty() && !scene) throw Error("page", "is of nothing: name clips, a result or a scene");
  py::list all;
  for (const py::handle thing : things) {
    if (py::isinstance<py::list>(thing) || py::isinstance<py::tuple>(thing))
      for (const py::handle one : thing.cast<py::sequence>()) all.append(one);
    else
      all.append(thing);
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
  } else if (all.empty() || results_of(Clip(), clips)) {
    out.page = page_of_clips(clips, names);
    out.page.title = names.empty() ? "inhabit" : names.front();
  } else {
    throw Error("page", "shows clips, or results of one kind");
  }
  if (scene) {
    out.scene = *scene;
    out.page.scene = &out.scene;
  }
  if (title) out.page.title = *title;
  if (note) out.page.note = *note;
  return {released([&] { return page_text(out.page, "page", page_template()); })};
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
         const std::optional<std::string>& note,
         const std::vector<std::string>& names) { return make_page(things, scene, title, note, names); },
      "scene"_a = py::none(), "title"_a = py::none(), "note"_a = py::none(), "names"_a = std::vector<std::string>(),
      "A Page of clips, or of what Forecaster, Anticipator, Inbetweener, Interactor, refine or reconstruct returned "
      "(several of\n"
      "Inbetweener or Interactor are samples). scene: shown with them; results know their own. names: of clips.");
}

}  // namespace inhabit::python
