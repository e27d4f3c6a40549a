// L0. The few type traits that the firmware zone needs: toolchains for small processors come
// without the C++ standard library.
#pragma once

namespace nfopidn::traits {

template <class A, class B>
constexpr bool is_same = false;
template <class A>
constexpr bool is_same<A, A> = true;

template <class T>
constexpr bool is_floating_point = is_same<T, float> || is_same<T, double>;

template <class T>
constexpr bool is_array = false;
template <class T, decltype(sizeof 0) count>
constexpr bool is_array<T[count]> = true;

template <bool condition, class T = void>
struct enable_if {};
template <class T>
struct enable_if<true, T> {
  using type = T;
};
template <bool condition>
using enable_if_t = typename enable_if<condition>::type;

template <class...>
struct always_void {
  using type = void;
};
template <class... Ts>
using void_t = typename always_void<Ts...>::type;

// For unevaluated operands alone.
template <class T>
T&& declval() noexcept;
template <class T>
void take(T) noexcept;

// void where there is one.
template <class From, class To>
using conversion = decltype(take<To>(declval<From>()));
template <class From, class To, class = void>
constexpr bool is_convertible = false;
template <class From, class To>
constexpr bool is_convertible<From, To, conversion<From, To>> = true;

// Numbers: what may be multiplied by an int and is neither a class nor an enum.
template <class T>
constexpr bool is_class = __is_class(T);
template <class T>
constexpr bool is_arithmetic = !__is_class(T) && !__is_enum(T) && is_convertible<T, double>;

template <class T, class = void>
constexpr bool is_unsigned = false;
template <class T>
constexpr bool is_unsigned<T, enable_if_t<is_arithmetic<T>>> = T(0) < T(-1);

// Of the whole numbers.
template <class T>
struct make_signed;
template <>
struct make_signed<unsigned char> {
  using type = signed char;
};
template <>
struct make_signed<unsigned short> {
  using type = short;
};
template <>
struct make_signed<unsigned int> {
  using type = int;
};
template <>
struct make_signed<unsigned long> {
  using type = long;
};
template <>
struct make_signed<unsigned long long> {
  using type = long long;
};
template <class T>
using make_signed_t = typename make_signed<T>::type;

}  // namespace nfopidn::traits
