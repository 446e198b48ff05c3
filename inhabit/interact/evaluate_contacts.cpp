#include "inhabit/interact/evaluate_contacts.h"

#include <map>

#include "inhabit/math/random.h"

namespace inhabit::interact {
namespace {

/// Contacts on one chair, in the axes of its seat.
using ContactSets = std::vector<HandContacts>;

HandContacts in_seat(const Chair& chair, HandContacts contacts) {
  for (auto& contact : contacts)
    if (contact) contact = chair.frame.inverse() * *contact;
  return contacts;
}

ContactScores score(const std::string& name, const std::vector<ContactSets>& chairs) {
  std::vector<double> apd, touching;
  int64_t with_contact = 0;
  for (const ContactSets& sets : chairs) {
    double sum = 0, hands = 0;
    int64_t pairs = 0;
    for (size_t side = 0; side < 2; ++side)
      for (size_t i = 0; i < sets.size(); ++i) {
        hands += sets[i][side] ? 0.5 : 0;
        for (size_t j = 0; j < i; ++j) {
          if (!sets[i][side] || !sets[j][side]) continue;
          sum += (*sets[i][side] - *sets[j][side]).norm();
          ++pairs;
        }
      }
    touching.push_back(hands / static_cast<double>(sets.size()));
    with_contact += hands > 0 ? 1 : 0;
    if (pairs > 0) apd.push_back(sum / static_cast<double>(pairs));
  }
  return {name, with_contact, estimate(apd), estimate(touching)};
}

}  // namespace

std::vector<ContactScores> evaluate_contacts(const std::vector<Trial>& trials, const ChairInteractor& interactor,
                                             int64_t draws, uint64_t seed) {
  std::map<std::string, std::vector<const Trial*>> by_chair;
  for (const Trial& trial : trials) by_chair[trial.scene_file].push_back(&trial);
  std::vector<ContactSets> recorded, drawn;
  for (const auto& [file, on_it] : by_chair) {
    const Chair& chair = on_it.front()->chair;
    ContactSets sets;
    for (const Trial* trial : on_it) sets.push_back(in_seat(trial->chair, trial->contacts));
    recorded.push_back(std::move(sets));
    sets.clear();
    for (const HandContacts& contacts : interactor.draw_contacts(chair, draws, item_seed(seed, drawn.size())))
      sets.push_back(in_seat(chair, contacts));
    drawn.push_back(std::move(sets));
  }
  return {score("data", recorded), score("ContactNet", drawn)};
}

ScoreTable score_table(const std::vector<ContactScores>& rows) {
  ScoreTable out;
  out.labels = {"contacts"};
  out.columns = {{"", "chairs", "chairs", 0}, {"", "APD (cm)", "apd_cm", 2}, {"", "hands (%)", "hands_percent", 1}};
  for (const ContactScores& s : rows)
    out.rows.push_back({{s.contacts},
                        {{static_cast<double>(s.chairs), 0},
                         {100 * s.apd.mean, 100 * s.apd.interval},
                         {100 * s.touching.mean, 100 * s.touching.interval}}});
  return out;
}

}  // namespace inhabit::interact
