#include "inhabit/reconstruct/reconstruction_page.h"

namespace inhabit::reconstruct {

Page reconstruction_page(const Result& result, const std::string& motion) {
  Page page;
  page.title = "Reconstruction of " + motion;
  page.note = "Grey: the estimate. Purple: the reconstruction. Red: the body is inside an object.";
  page.scene = &result.scene;
  PagePerson person{result.motion, "reconstruction", PagePerson::Role::filled};
  person.keys = result.keys;
  person.given = result.key_poses;
  person.collides = result.collides;
  for (const Immersion& in : result.immersions) person.collides_with.push_back(in.text());
  page.people.push_back(person);
  page.people.push_back({result.before, "estimate", PagePerson::Role::past});
  return page;
}

}  // namespace inhabit::reconstruct
