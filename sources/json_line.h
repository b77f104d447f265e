/// The numbers of one JSON object on one line, with their names: a pure function over bytes, no allocation.
#pragma once
#include <functional>
#include <string_view>
#include <type_traits>

namespace stillpoint::sources {

/// A reference to a callable that lives longer than the call.
class OnNumber {
 public:
  template <class F>
  OnNumber(F& f) noexcept  // NOLINT(google-explicit-constructor): a lambda is handed over as it stands
      : object_(&f), call_([](void* o, std::string_view name, double x) { (*static_cast<F*>(o))(name, x); }) {}
  void operator()(std::string_view name, double value) const { call_(object_, name, value); }

 private:
  void* object_;
  void (*call_)(void*, std::string_view, double);
};

/// Calls `on_number` for each number, in quotes or not; names of inner objects and places in arrays are joined with
/// dots: "imu.acc.0". False: the line is no whole JSON object, or nested deeper than eight levels.
[[nodiscard]] bool for_each_number_of(std::string_view line, const OnNumber& on_number) noexcept;

template <class F>
[[nodiscard]] bool for_each_number(std::string_view line, F f) noexcept {
  return for_each_number_of(line, OnNumber(f));
}

}  // namespace stillpoint::sources
