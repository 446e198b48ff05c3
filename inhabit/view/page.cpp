#include "inhabit/view/page.h"

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/view/page_parts.h"
#include "inhabit/view/page_template.h"

namespace inhabit {
namespace {

using nlohmann::json;

constexpr int64_t kMaxTriangles = 200'000, kMaxPoints = 60'000;

json describe_recordings(const PageRecordings& recordings, const std::string& path) {
  if (!(recordings.rate > 0) || !std::isfinite(recordings.rate)) throw Error(path, "recordings need a rate above zero");
  json rows = json::array();
  for (const PageRecordings::Row& row : recordings.rows)
    rows.push_back({{"name", row.name},
                    {"group", row.group},
                    {"frames", row.labels.numel()},
                    {"spans", intention_spans(row.labels, path)},
                    {"marked", row.marked}});
  return {{"rate", recordings.rate}, {"rows", rows}};
}

}  // namespace

std::string page_text(const Page& page, const std::string& path, std::string_view page_template) {
  if (page.people.empty() && (page.scene == nullptr || page.scene->empty())) throw Error(path, "nothing to show");
  PageBlob blob;
  PageBodies bodies;
  json header = {{"note", page.note}, {"people", json::array()}};
  for (const PagePerson& person : page.people) header["people"].push_back(describe_person(blob, bodies, person, path));
  if (page.people.empty()) bodies.add(blob, builtin_body(), {}, kStandardJoints);  // for what is dropped on it
  header["bodies"] = bodies.list;
  if (page.scene != nullptr) header["scene"] = describe_scene(blob, *page.scene, path, kMaxTriangles, kMaxPoints);
  if (page.recordings) header["recordings"] = describe_recordings(*page.recordings, path);
  if (page.contacts) header["contacts"] = describe_contacts(blob, *page.contacts, path);
  return page_document(page.title, std::move(header), blob, page_template);
}

void write_page(const std::string& path, const Page& page) {
  write_atomically(path, page_text(page, path, page_template()));
}

}  // namespace inhabit