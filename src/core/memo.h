// Values that remember the inputs that they were made of.
#pragma once
#include <optional>

namespace glowworm {

/// A stage of a longer computation: its value, and the inputs that it was made of. A stage that depends on another has
/// inputs that derive from the other's, so a change of any earlier input makes it anew.
template <class Inputs, class Value>
class Memo {
 public:
  /// Sets the value to make(), unless it was made of equal inputs. The old value is freed before. Without a value where
  /// make() throws.
  template <class Make>
  const Value& update(const Inputs& inputs, const Make& make) {
    if (is_made_of(inputs)) return value_;
    clear();
    value_ = make();
    inputs_ = inputs;
    return value_;
  }
  bool is_made_of(const Inputs& inputs) const { return inputs_ && *inputs_ == inputs; }
  /// Frees a value that was made of other inputs.
  void keep_if(const Inputs& inputs) {
    if (!is_made_of(inputs)) clear();
  }
  void clear() {
    inputs_.reset();
    value_ = Value();
  }

  /// The inputs; null without a value.
  const Inputs* inputs() const { return inputs_ ? &*inputs_ : nullptr; }
  /// The value; empty without one.
  const Value& operator*() const { return value_; }
  const Value* operator->() const { return &value_; }

 private:
  std::optional<Inputs> inputs_;
  Value value_{};
};

}  // namespace glowworm
