#include "inhabit/view/cards_page.h"

#include <map>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/view/page_parts.h"
#include "inhabit/view/page_template.h"

namespace inhabit {

using nlohmann::json;

namespace {

constexpr int64_t kCardTriangles = 20'000, kCardPoints = 10'000;

json describe_chart(const PageChart& chart, const std::string& path) {
  json panels = json::array();
  for (const PageChart::Panel& panel : chart.panels) {
    json all = json::array();
    for (const PageChart::Series& series : panel.series) {
      const size_t expected = panel.ticks.empty() ? series.x.size() : panel.ticks.size();
      if (series.y.size() != expected || (!series.interval.empty() && series.interval.size() != expected))
        throw Error(path, "chart " + panel.title + " has other values than places for them");
      json one = {{"name", series.name}, {"y", series.y}};  // NaN becomes null
      if (panel.ticks.empty()) one["x"] = series.x;
      if (!series.interval.empty()) one["interval"] = series.interval;
      all.push_back(std::move(one));
    }
    json out = {{"title", panel.title}, {"group", panel.group}, {"bars", panel.bars}, {"series", std::move(all)}};
    if (!panel.ticks.empty()) out["ticks"] = panel.ticks;
    panels.push_back(std::move(out));
  }
  return {{"x", chart.x}, {"panels", std::move(panels)}};
}

}  // namespace

std::string page_text(const CardsPage& page, const std::string& path) {
  if (page.cards.empty()) throw Error(path, "nothing to show");
  PageBlob blob;
  PageBodies bodies;
  json header = {{"note", page.note}, {"people", json::array()}, {"scenes", json::array()}, {"cards", json::array()}};
  std::map<const Scene*, size_t> known;
  for (const PageCard& card : page.cards) {
    json out = {{"name", card.name}, {"note", card.note}};
    if (card.person) {
      PagePerson person = *card.person;
      person.joints_alone = true;
      out["person"] = describe_person(blob, bodies, person, path);
    }
    if (card.scene != nullptr) {
      const auto [found, is_new] = known.try_emplace(card.scene.get(), known.size());
      if (is_new) header["scenes"].push_back(describe_scene(blob, *card.scene, path, kCardTriangles, kCardPoints));
      out["scene"] = found->second;
    }
    if (card.chart) out["chart"] = describe_chart(*card.chart, path);
    header["cards"].push_back(std::move(out));
  }
  header["bodies"] = bodies.list;
  return page_document(page.title, std::move(header), blob, page_template());
}

void write_page(const std::string& path, const CardsPage& page) { write_atomically(path, page_text(page, path)); }

std::string empty_page_text(const std::string& title, const std::string& note) {
  PageBlob blob;
  PageBodies bodies;
  bodies.add(blob, builtin_body(), {}, kStandardJoints);
  const json header = {{"note", note}, {"people", json::array()}, {"bodies", bodies.list}};
  return page_document(title, header, blob, page_template());
}

void write_empty_page(const std::string& path, const std::string& title, const std::string& note) {
  write_atomically(path, empty_page_text(title, note));
}

}  // namespace inhabit
