#pragma once
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "../inhabit.h"
#include "inhabit/anticipate/anticipate_stream.h"
#include "inhabit/error.h"
#include "inhabit/forecast/forecast_stream.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/interact/chair_interactor.h"

// What the opaque handles of inhabit.h are, and how exceptions end at its border.

/// A motion.
struct inhabit_clip {
  inhabit::Clip clip;                           ///< as read or given
  std::map<std::string, torch::Tensor> arrays;  ///< by the names of inhabit_clip_array(), contiguous, on the CPU
};

/// A room.
struct inhabit_scene {
  inhabit::Scene scene;  ///< as read
};

/// Refinement, which has no model.
struct Refiner {};

/// One of the systems with its model.
struct inhabit_system {
  std::variant<std::shared_ptr<const inhabit::forecast::ContactForecaster>,
               std::shared_ptr<const inhabit::anticipate::IntentionAnticipator>,
               std::shared_ptr<const inhabit::inbetween::SceneInbetweener>,
               std::shared_ptr<const inhabit::interact::ChairInteractor>, Refiner>
      system;  ///< which one
};

/// What a system made.
struct inhabit_result {
  std::vector<inhabit::Clip> clips;             ///< on the standard skeleton
  std::vector<inhabit::Clip> on_source;         ///< the same on the input's own skeleton, where there is such a one
  std::map<std::string, torch::Tensor> arrays;  ///< by the names of inhabit_result_array()
};

namespace inhabit::c {

/// Keeps what inhabit_last_error() says of this thread.
void set_last_error(const std::string& text) noexcept;
const char* last_error() noexcept;

/// What `call` returns; where it throws, `failed` and its reason is kept.
template <class Call, class Value>
Value guarded(Value failed, const Call& call) noexcept {
  try {
    return call();
  } catch (const Error& error) {
    set_last_error(error.what());
  } catch (const std::bad_alloc&) {
    set_last_error("out of memory");
  } catch (const std::exception& error) {
    const std::string what = error.what();  // LibTorch appends a stack trace
    set_last_error("unexpected: " + what.substr(0, what.find('\n')));
  } catch (...) {
    set_last_error("unexpected: an exception of another kind");
  }
  return failed;
}

/// Throws where an argument that must be there is NULL.
template <class T>
T& needed(T* pointer, const char* name) {
  if (pointer == nullptr) throw Error(name, "is NULL");
  return *pointer;
}

inline std::string text_of(const char* text, const char* name) { return &needed(text, name); }

/// A handle of a clip with its arrays.
inhabit_clip* clip_handle(Clip clip);

/// `name` among arrays. Throws Error where there is none.
void fill_array(const std::map<std::string, torch::Tensor>& arrays, const std::string& name, inhabit_array& out);

/// A tensor as an array of a handle is kept: contiguous float32 or int64.
torch::Tensor kept(const torch::Tensor& tensor);

inhabit_result result_of(forecast::Result result);
inhabit_result result_of(anticipate::Result result);

}  // namespace inhabit::c
