// Declares the parameters of a technique as fields of a struct: one table from which their description, their checks
// and their parsing follow. Defaults are those of the struct's members.
//   struct MineParameters : CommonParameters {
//     std::uint32_t surfaces = 4;
//     Coverage coverage = Coverage::table;
//   };
//   const Fields<MineParameters> fields{
//       field::samples({4, 8}),
//       field::integer("surfaces", &MineParameters::surfaces, {1, 8}, "surfaces kept for a pixel"),
//       field::choice("coverage", &MineParameters::coverage, "how masks are made",
//                     {{"lut", Coverage::table}, {"exact", Coverage::exact}})};
#pragma once

#include <concepts>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "replay/results/parameters.hpp"

namespace subpixel::replay {

// One parameter: how it is described, and the member of `Struct` that holds it.
template <typename Struct>
struct Field {
  Parameter described;                                               // but its default
  std::function<void(Struct&, const nlohmann::json& checked)> read;  // from what check_parameters() lets through
  std::function<nlohmann::json(const Struct&)> value;

  Field(Parameter parameter, std::function<void(Struct&, const nlohmann::json&)> reading,
        std::function<nlohmann::json(const Struct&)> written)
      : described(std::move(parameter)), read(std::move(reading)), value(std::move(written)) {}
  // A field of a struct is one of those derived from it.
  template <typename Base>
  requires(std::derived_from<Struct, Base> && !std::same_as<Struct, Base>) Field(const Field<Base>& base)
      : described(base.described), read(base.read), value(base.value) {}
};

template <typename Struct>
class Fields {
 public:
  Fields(std::initializer_list<Field<Struct>> fields) : fields_(fields) {}

  // What help, HTTP and the page's forms are made of.
  Parameters description() const {
    const Struct defaults;
    Parameters parameters;
    for (const Field<Struct>& field : fields_) {
      parameters.push_back(field.described);
      parameters.back().default_value = field.value(defaults);
    }
    return parameters;
  }

  // `checked`: all of them, as check_parameters() returns them.
  Struct read(const ParameterValues& checked) const {
    Struct values;
    for (const Field<Struct>& field : fields_) field.read(values, checked.at(std::string(field.described.name)));
    return values;
  }

 private:
  std::vector<Field<Struct>> fields_;
};

namespace field {

// The values a number may have: those from `minimum` to `maximum`, or some of them.
struct Range {
  double minimum = 0, maximum = 0;
  std::vector<double> allowed = {};
};
// In ascending order.
inline Range one_of(const std::vector<double>& values) {
  return {values.front(), values.back(), values};
}

inline Parameter describe(std::string_view name, ParameterKind kind, std::string_view doc, std::string_view unit = "",
                          const Range& range = {}) {
  return {name, kind, doc, unit, range.minimum, range.maximum, range.allowed, {}, {}};
}

template <typename Struct, std::integral Integer>
Field<Struct> integer(std::string_view name, Integer Struct::*member, const Range& range, std::string_view doc,
                      std::string_view unit = "") {
  return {describe(name, ParameterKind::integer, doc, unit, range),
          [member](Struct& s, const nlohmann::json& checked) { s.*member = checked.get<Integer>(); },
          [member](const Struct& s) { return nlohmann::json(std::int64_t{s.*member}); }};
}

template <typename Struct>
Field<Struct> number(std::string_view name, double Struct::*member, const Range& range, std::string_view doc,
                     std::string_view unit = "") {
  return {describe(name, ParameterKind::number, doc, unit, range),
          [member](Struct& s, const nlohmann::json& checked) { s.*member = checked.get<double>(); },
          [member](const Struct& s) { return nlohmann::json(s.*member); }};
}

// Between directions, in radians.
template <typename Struct>
Field<Struct> angle(std::string_view name, double Struct::*member, std::string_view doc) {
  return number(name, member, {0, std::numbers::pi}, doc, "radians");
}

template <typename Struct>
Field<Struct> condition(std::string_view name, bool Struct::*member, std::string_view doc) {
  return {describe(name, ParameterKind::boolean, doc),
          [member](Struct& s, const nlohmann::json& checked) { s.*member = checked.get<bool>(); },
          [member](const Struct& s) { return nlohmann::json(s.*member); }};
}

// `names`: every value of the enumeration that can be chosen, as users spell it.
template <typename Struct, typename Enum>
Field<Struct> choice(std::string_view name, Enum Struct::*member, std::string_view doc,
                     std::initializer_list<std::pair<std::string_view, std::type_identity_t<Enum>>> names) {
  Parameter parameter = describe(name, ParameterKind::choice, doc);
  for (const auto& named : names) parameter.choices.push_back(named.first);
  const std::vector<std::pair<std::string_view, Enum>> values(names);
  return {std::move(parameter),
          [member, values](Struct& s, const nlohmann::json& checked) {
            for (const auto& [text, value] : values)
              if (checked.get_ref<const std::string&>() == text) s.*member = value;
          },
          [member, values](const Struct& s) {
            nlohmann::json text;
            for (const auto& named : values)
              if (named.second == s.*member) text = std::string(named.first);
            return text;
          }};
}

}  // namespace field
}  // namespace subpixel::replay
