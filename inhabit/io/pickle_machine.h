#pragma once
#include <cstdint>
#include <unordered_map>

#include "inhabit/error.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/pickle_globals.h"

namespace inhabit {

/// For pickle_machine.cpp and pickle_text.cpp alone: the machine that a pickle is a program of, with a stack, marks on
/// it and a memo. Values go into one store, so that those which contain themselves cost nothing.
class PickleMachine {
 public:
  /// @param storages of a file of torch.save, whose pickle says by a key which numbers after it a tensor views; null:
  /// of any other pickle
  PickleMachine(std::string_view bytes, const std::string& about, TorchStorages* storages = nullptr)
      : bytes_(bytes), subject_(about), storages_(storages) {}

  Pickle run() {
    if (bytes_.empty()) throw Error(subject_, "is empty");
    while (!done_) step(static_cast<unsigned char>(take(1)[0]));
    Value* root = pop();
    if (root->kind == Kind::storage && storages_ != nullptr) root->kind = Kind::array;
    check(*root);
    return {subject_, values_, root};
  }

  /// Bytes that the pickle took.
  size_t used() const { return at_; }

 private:
  using Value = PickleValue;
  using Kind = PickleValue::Kind;
  static constexpr size_t kMostValues = size_t{1} << 24;

  [[noreturn]] void damaged(const std::string& how) const { throw Error(subject_, "is no pickle: " + how); }

  std::string_view take(uint64_t count) {
    if (count > bytes_.size() - at_) throw Error(subject_, "ends early");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  uint64_t number(int count) {
    const std::string_view raw = take(static_cast<uint64_t>(count));
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; --i) value = (value << 8) | static_cast<unsigned char>(raw[static_cast<size_t>(i)]);
    return value;
  }
  std::string line() {
    const size_t end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) throw Error(subject_, "ends early");
    std::string out(take(end - at_));
    take(1);
    return out;
  }

  Value& make(Kind kind) {
    if (values_->size() >= kMostValues) throw Error(subject_, "holds too many values");
    Value& value = values_->emplace_back();
    value.kind = kind;
    return value;
  }
  void push(Value* value) {
    if (stack_.size() >= kMostValues) throw Error(subject_, "holds too many values");
    stack_.push_back(value);
  }
  void push_text(Kind kind, std::string_view text) {
    Value& value = make(kind);
    value.text = text;
    push(&value);
  }
  void push_whole(int64_t whole) {
    Value& value = make(Kind::whole);
    value.whole = whole;
    push(&value);
  }
  void push_boolean(bool boolean) {
    Value& value = make(Kind::boolean);
    value.boolean = boolean;
    push(&value);
  }
  Value* top() {
    if (stack_.size() <= (marks_.empty() ? 0 : marks_.back())) damaged("its stack is empty");
    return stack_.back();
  }
  Value* pop() {
    Value* value = top();
    stack_.pop_back();
    return value;
  }
  /// What was pushed since the last mark.
  std::vector<const Value*> pop_marked() {
    if (marks_.empty()) damaged("it has no mark");
    std::vector<const Value*> out(stack_.begin() + static_cast<std::ptrdiff_t>(marks_.back()), stack_.end());
    stack_.resize(marks_.back());
    marks_.pop_back();
    return out;
  }
  void collect(Kind kind, std::vector<const Value*> items) {
    if (kind == Kind::dict && items.size() % 2 != 0) damaged("a key without a value");
    Value& value = make(kind);
    value.items = std::move(items);
    push(&value);
  }
  void extend(Kind kind, const std::vector<const Value*>& items) {
    Value* to = top();
    if (to->kind != kind || (kind == Kind::dict && items.size() % 2 != 0)) damaged("it adds to something else");
    extended_ += items.size();
    if (extended_ > kMostValues) throw Error(subject_, "holds too many values");
    to->items.insert(to->items.end(), items.begin(), items.end());
  }
  void collect_last(size_t count) {
    std::vector<const Value*> items(count);
    for (size_t i = count; i-- > 0;) items[i] = pop();
    collect(Kind::tuple, std::move(items));
  }

  void remember(uint64_t key) { memo_[key] = top(); }
  void recall(uint64_t key) {
    const auto found = memo_.find(key);
    if (found == memo_.end()) damaged("it recalls what it has not stored");
    push(found->second);
  }
  uint64_t key_of_line() {
    const std::string text = line();
    uint64_t key = 0;
    for (const char c : text) {
      if (c < '0' || c > '9' || key > UINT32_MAX) damaged("a wrong number of its memo");
      key = 10 * key + static_cast<uint64_t>(c - '0');
    }
    return key;
  }

  void global(const std::string& module, const std::string& name) {
    const std::string allowed = allowed_global(module, name);
    if (allowed.empty()) {
      std::string shown = (module + "." + name).substr(0, 120);
      for (char& c : shown)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = '?';
      throw Error(subject_, "needs " + shown + ", which is neither a plain value nor a NumPy array: it is not loaded");
    }
    push_text(Kind::name, allowed);
  }
  void reduce() {
    const Value* arguments = pop();
    const Value* called = pop();
    if (called->kind != Kind::name || arguments->kind != Kind::tuple) damaged("it calls something that is no function");
    // A file inside a file has none inside: how deep they lie would be up to the file.
    if (storages_ != nullptr && called->text == "load_from_bytes") damaged("a file of torch.save in another");
    Value result = call_global(called->text, *arguments, subject_);
    Value& value = make(result.kind);
    value = std::move(result);
    push(&value);
  }

  void push_storage();
  void push_decimal(std::string text);
  void push_long(uint64_t count);
  void push_real(double real) {
    Value& value = make(Kind::real);
    value.real = real;
    push(&value);
  }

  std::string unescaped(const std::string& raw) const;
  std::string unquoted(const std::string& quoted) const;
  void step(unsigned char op);
  void step_text(unsigned char op);   ///< of protocols 0 and 1 that hold lines of text
  void step_newer(unsigned char op);  ///< of protocols 2 to 5
  void check(const Value& root) const;

  std::string_view bytes_;
  const std::string& subject_;
  TorchStorages* storages_;
  size_t at_ = 0, extended_ = 0;
  bool done_ = false;
  std::shared_ptr<std::deque<Value>> values_ = std::make_shared<std::deque<Value>>();
  std::vector<Value*> stack_;
  std::vector<size_t> marks_;
  std::unordered_map<uint64_t, Value*> memo_;
};

}  // namespace inhabit
