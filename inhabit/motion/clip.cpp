#include "inhabit/motion/clip.h"

#include "inhabit/error.h"

namespace inhabit {

Clip person_of(const Clip& clip) {
  Clip out;
  out.skeleton = clip.skeleton;
  out.rate = clip.rate;
  out.betas = clip.betas;
  out.gender = clip.gender;
  out.source_body = clip.source_body;
  out.source_betas = clip.source_betas;
  out.file = clip.file;
  return out;
}

Clip frames_at(const Clip& clip, const std::vector<int64_t>& frames) {
  const torch::Tensor at = torch::tensor(frames);
  Clip out = person_of(clip);
  out.joints = clip.joints.index_select(0, at);
  if (clip.rotations.defined()) out.rotations = clip.rotations.index_select(0, at);
  if (clip.trans.defined()) out.trans = clip.trans.index_select(0, at);
  if (clip.translations.defined()) out.translations = clip.translations.index_select(0, at);
  return out;
}

Clip slice(const Clip& clip, int64_t first, int64_t last) {
  Clip out = clip;
  for (torch::Tensor* t : {&out.joints, &out.rotations, &out.trans, &out.translations, &out.action, &out.contact,
                           &out.hand_targets, &out.object_pose})
    if (t->defined()) *t = t->slice(0, first, last);
  return out;
}

void validate(const Clip& clip, const std::string& subject) {
  clip.skeleton.validate(subject);
  if (!(clip.rate >= 0.1 && clip.rate <= 1000))
    throw Error(subject, "frame rate " + std::to_string(clip.rate) + " is not in [0.1, 1000]");
  if (clip.frames() == 0) throw Error(subject, "no frames");
  const int64_t T = clip.frames(), J = clip.skeleton.size();
  auto check = [&](const char* name, const torch::Tensor& t, std::vector<int64_t> shape) {
    if (!t.defined()) return;
    if (t.sizes().vec() != shape) throw Error(subject, std::string(name) + " has the wrong shape");
    if (t.is_floating_point() && !torch::isfinite(t).all().item<bool>())
      throw Error(subject, std::string(name) + " has a value that is not finite");
  };
  check("joints", clip.joints, {T, J, 3});
  if (!(clip.joints.abs().max().item<double>() < 1e5)) throw Error(subject, "a joint is over 100 km from the origin");
  check("rotations", clip.rotations, {T, J, 3});
  check("trans", clip.trans, {T, 3});
  check("translations", clip.translations, {T, J, 3});
  check("action", clip.action, {T});
  check("contact", clip.contact, {T, J});
  check("hand_targets", clip.hand_targets, {T, 2, 4});
  check("object_pose", clip.object_pose, {T, static_cast<int64_t>(clip.object_names.size()), 6});
  if (clip.betas.defined() && !torch::isfinite(clip.betas).all().item<bool>())
    throw Error(subject, "betas have a value that is not finite");
}

}  // namespace inhabit
