#include "inhabit/io/pickle_machine.h"

#include <cstring>
#include <unordered_set>

namespace inhabit {

void PickleMachine::step(unsigned char op) {
  switch (op) {
    case '.':
      done_ = true;
      return;
    case '(':
      if (marks_.size() >= kMostValues) throw Error(subject_, "holds too many values");
      return marks_.push_back(stack_.size());
    case '0':
      if (!marks_.empty() && marks_.back() == stack_.size()) return marks_.pop_back();
      pop();
      return;
    case '1':
      pop_marked();
      return;
    case '2':
      return push(top());
    case 'N':
      return push(&make(Kind::none));
    case 'J':
      return push_whole(static_cast<int32_t>(number(4)));
    case 'K':
      return push_whole(static_cast<int64_t>(number(1)));
    case 'M':
      return push_whole(static_cast<int64_t>(number(2)));
    case 'G': {
      const std::string_view raw = take(8);  // the high byte first
      uint64_t bits = 0;
      for (const char c : raw) bits = (bits << 8) | static_cast<unsigned char>(c);
      double real = 0;
      std::memcpy(&real, &bits, 8);
      return push_real(real);
    }
    case 'T':
    case 'X':
      return push_text(Kind::text, take(number(4)));
    case 'U':
      return push_text(Kind::text, take(number(1)));
    case 'B':
      return push_text(Kind::bytes, take(number(4)));
    case 'C':
      return push_text(Kind::bytes, take(number(1)));
    case ')':
      return collect(Kind::tuple, {});
    case ']':
      return collect(Kind::list, {});
    case '}':
      return collect(Kind::dict, {});
    case 't':
      return collect(Kind::tuple, pop_marked());
    case 'l':
      return collect(Kind::list, pop_marked());
    case 'd':
      return collect(Kind::dict, pop_marked());
    case 'a': {
      const Value* item = pop();
      return extend(Kind::list, {item});
    }
    case 'e': {
      const std::vector<const Value*> items = pop_marked();
      return extend(Kind::list, items);
    }
    case 's': {
      const Value* value = pop();
      const Value* key = pop();
      return extend(Kind::dict, {key, value});
    }
    case 'u': {
      const std::vector<const Value*> items = pop_marked();
      return extend(Kind::dict, items);
    }
    case 'R':
      return reduce();
    case 'b': {
      const Value* state = pop();
      return set_state(*top(), *state, subject_);
    }
    case 'q':
      return remember(number(1));
    case 'r':
      return remember(number(4));
    case 'h':
      return recall(number(1));
    case 'j':
      return recall(number(4));
    case 'Q':
      return push_storage();
    default:
      return op >= 0x80 ? step_newer(op) : step_text(op);
  }
}

void PickleMachine::step_newer(unsigned char op) {
  switch (op) {
    case 0x80:
      if (number(1) > 5) throw Error(subject_, "is a pickle of a newer protocol than 5");
      return;
    case 0x81:  // a class's __new__: as a call for those that are allowed
      return reduce();
    case 0x85:
    case 0x86:
    case 0x87:
      return collect_last(op - 0x84U);
    case 0x88:
    case 0x89:
      return push_boolean(op == 0x88);
    case 0x8a:
      return push_long(number(1));
    case 0x8b:
      return push_long(number(4));
    case 0x8c:
      return push_text(Kind::text, take(number(1)));
    case 0x8d:
      return push_text(Kind::text, take(number(8)));
    case 0x8e:
    case 0x96:
      return push_text(Kind::bytes, take(number(8)));
    case 0x8f:
      return collect(Kind::set, {});
    case 0x90: {
      const std::vector<const Value*> items = pop_marked();
      return extend(Kind::set, items);
    }
    case 0x91:
      return collect(Kind::set, pop_marked());
    case 0x93: {
      const Value* name = pop();
      const Value* module = pop();
      if (name->kind != Kind::text || module->kind != Kind::text) damaged("a global without a name");
      return global(module->text, name->text);
    }
    case 0x94:
      return remember(memo_.size());
    case 0x95:  // how long a frame is: nothing depends on it
      number(8);
      return;
    case 0x97:
    case 0x98:
      throw Error(subject_, "keeps its data in another file");
    default:
      return step_text(op);
  }
}

/// What torch.save knows by a key: numbers that come after the pickle.
void PickleMachine::push_storage() {
  if (storages_ == nullptr) damaged("it needs what is kept elsewhere");
  const Value* told = pop();
  Value& value = make(Kind::storage);
  value.array = torch_storage(*told, *storages_, subject_);
  push(&value);
}

/// Goes through all values once, and down at most kDeepest of them.
void PickleMachine::check(const Value& root) const {
  constexpr size_t kDeepest = 100;
  struct Place {
    const Value* value;
    size_t next;
  };
  std::vector<Place> path = {{&root, 0}};
  std::unordered_set<const Value*> on_path = {&root}, seen;
  while (!path.empty()) {
    Place& place = path.back();
    if (place.next == 0) {
      if (place.value->kind == Kind::name || place.value->kind == Kind::dtype || place.value->kind == Kind::pending ||
          place.value->kind == Kind::storage)
        throw Error(subject_, "holds a type or an array without data where a value is expected");
      if (path.size() > kDeepest) throw Error(subject_, "holds values more than 100 deep in one another");
    }
    if (place.next == place.value->items.size()) {
      on_path.erase(place.value);
      seen.insert(place.value);
      path.pop_back();
      continue;
    }
    const Value* item = place.value->items[place.next++];
    if (on_path.count(item) != 0) throw Error(subject_, "holds a value that contains itself");
    if (seen.count(item) != 0) continue;
    on_path.insert(item);
    path.push_back({item, 0});
  }
}

Pickle parse_pickle(std::string_view bytes, const std::string& subject) { return PickleMachine(bytes, subject).run(); }

}  // namespace inhabit
