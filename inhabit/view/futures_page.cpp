#include "inhabit/view/futures_page.h"

#include <cstdio>

#include "inhabit/error.h"

namespace inhabit {
namespace {

/// The joints alone: bodies of fifty people would be neither small nor quick.
Clip joints_of(const Clip& clip) {
  Clip out;
  out.skeleton = clip.skeleton;
  out.rate = clip.rate;
  out.joints = clip.joints;
  return out;
}

std::string one_decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

}  // namespace

Page futures_page(const Clip& past, const std::vector<Clip>& futures, const std::vector<torch::Tensor>& labels) {
  if (futures.empty()) throw Error("futures", "there is none to show");
  if (!labels.empty() && labels.size() != futures.size())
    throw Error("futures", "labels of " + std::to_string(labels.size()) + " for " + std::to_string(futures.size()));
  Page page;
  page.title = std::to_string(futures.size()) + (futures.size() == 1 ? " future" : " futures") + " of one observation";
  page.note = "Grey: the " + one_decimal(past.seconds()) + " s that were observed. Then " +
              one_decimal(futures.front().seconds()) + " s as they may go on.";
  page.people.push_back({joints_of(past), "observed", PagePerson::Role::past, 0, nullptr});
  for (size_t i = 0; i < futures.size(); ++i) {
    page.people.push_back({joints_of(futures[i]), "future " + std::to_string(i), PagePerson::Role::future,
                           past.seconds(), nullptr, labels.empty() ? torch::Tensor() : labels[i]});
  }
  return page;
}

}  // namespace inhabit
