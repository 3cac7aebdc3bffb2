#include "scenes/import/mtl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

// Statements that say nothing here or are in every file: ambient and specular colour, refraction, lighting model, ...
const std::set<std::string, std::less<>> kSilent{"ka",        "ks",  "ni",     "illum",  "tf",
                                                 "sharpness", "pcr", "anisor", "map_aat"};
// Statements that have no effect, but are only worth a notice when they are not 0.
const std::set<std::string, std::less<>> kSilentWhenZero{"ps", "pc", "aniso", "km"};

// Number of values after an option of a map; -1: up to three numbers.
const std::map<std::string, int, std::less<>> kMapOptions{
    {"-blendu", 1}, {"-blendv", 1}, {"-boost", 1}, {"-bm", 1}, {"-cc", 1},     {"-clamp", 1}, {"-imfchan", 1},
    {"-mm", 2},     {"-o", -1},     {"-s", -1},    {"-t", -1}, {"-texres", 1}, {"-type", 1},  {"-colorspace", 1}};

bool contains_meshlab(const std::vector<std::byte>& file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  constexpr std::size_t kHead = 512;
  return lower_case(text.substr(0, kHead)).find("meshlab") != std::string::npos;
}

class MtlParser {
 public:
  MtlParser(std::vector<std::byte> file, const std::string& where)
      : by_meshlab_(contains_meshlab(file)), name_(short_name(where)), statements_(std::move(file), where, false) {}

  MtlLibrary parse() {
    while (const std::optional<Statement> statement = statements_.next()) take(*statement);
    for (const auto& [keyword, line] : ignored_) {
      library_.notices.push_back(fmt::format("ignored: {} of {}, first in line {}", keyword, name_, line));
    }
    library_.tr_is_opacity = by_meshlab_ || tr_must_be_opacity();
    return std::move(library_);
  }

 private:
  static std::string short_name(const std::string& where) { return to_utf8(where.substr(where.find_last_of('/') + 1)); }

  void take(const Statement& statement) {
    const std::string& key = statement.keyword;
    if (key == "newmtl") {
      library_.materials.push_back({std::string(statement.rest), statements_.place(), {}, {}, {}, {}, {}, {}, {}});
      return;
    }
    if (library_.materials.empty()) return ignore(key + " before any newmtl");
    MtlMaterial& material = library_.materials.back();
    if (key == "kd") return take_colour(statement.rest, key, material.kd);
    if (key == "ke") return take_colour(statement.rest, key, material.ke);
    for (const auto& [name, value] : {std::pair{"ns", &material.ns},
                                      {"d", &material.d},
                                      {"tr", &material.tr},
                                      {"pr", &material.pr},
                                      {"pm", &material.pm}}) {
      if (key == name) return take_number(statement.rest, name, *value);
    }
    for (const auto& [name, map] : {std::pair{"map_kd", &material.map_kd},
                                    {"map_d", &material.map_d},
                                    {"map_opacity", &material.map_d},
                                    {"map_ke", &material.map_ke},
                                    {"map_emissive", &material.map_ke},
                                    {"map_pr", &material.map_pr},
                                    {"map_pm", &material.map_pm},
                                    {"norm", &material.norm},
                                    {"map_kn", &material.norm},
                                    {"map_bump", &material.bump},
                                    {"bump", &material.bump}}) {
      if (key == name) return take_map(statement.rest, *map);
    }
    if (kSilent.contains(key)) return;
    if (kSilentWhenZero.contains(key)) {
      std::string_view rest = statement.rest;
      if (parse_number(take_token(rest)) == 0.0) return;
    }
    ignore(key);
  }

  // One value is all three.
  void take_colour(std::string_view rest, const std::string& key, std::optional<glm::dvec3>& colour) {
    rest = without_comment(rest);
    std::string_view token = take_token(rest);
    if (token == "spectral" || token == "xyz") return ignore(key + " " + std::string(token));
    glm::dvec3 value(statements_.number(token, "a component of a colour"));
    for (int i = 1; i < 3; ++i) {
      token = take_token(rest);
      if (!token.empty()) value[i] = statements_.number(token, "a component of a colour");
    }
    colour = value;
  }

  // The last one: `d -halo 0.5` has an option before.
  void take_number(std::string_view rest, const char* what, std::optional<double>& number) {
    rest = without_comment(rest);
    const std::size_t blank = rest.find_last_of(" \t");
    const bool has_option = rest.starts_with('-') && blank != std::string_view::npos;
    std::string_view token = has_option ? rest.substr(blank + 1) : take_token(rest);
    number = statements_.number(token, what);
  }

  void take_map(std::string_view rest, std::optional<MtlMap>& map) {
    MtlMap found;
    found.place = statements_.place();
    while (rest.starts_with('-') && take_option(rest, found)) rest = without_blanks(rest);
    rest = without_trailing_options(rest, found);
    if (rest.size() >= 2 && rest.front() == '"' && rest.back() == '"') rest = rest.substr(1, rest.size() - 2);
    if (rest.empty()) return;  // "map_Kd" alone is how some exporters say none
    found.file = std::string(rest);
    map = std::move(found);
  }

  // Cuts an option with its values off `rest`. False, with `rest` as it was, when it is the file's name.
  bool take_option(std::string_view& rest, MtlMap& map) {
    std::string_view left = rest;
    const std::string option = lower_case(take_token(left));
    const auto known = kMapOptions.find(option);
    if (known == kMapOptions.end()) return false;
    std::array<double, 3> numbers{};
    std::string_view value;
    int count = 0;
    for (const int most = known->second < 0 ? 3 : known->second; count < most; ++count) {
      std::string_view ahead = left;
      const std::string_view token = take_token(ahead);
      const std::optional<double> number = parse_number(token);
      if (known->second < 0 && !number) break;  // the name follows
      if (known->second < 0) numbers[static_cast<std::size_t>(count)] = statements_.number(token, option.c_str());
      if (count == 0) value = token;
      left = ahead;
    }
    rest = left;
    apply_option(option, value, numbers, count, map);
    return true;
  }

  void apply_option(const std::string& option, std::string_view value, const std::array<double, 3>& numbers, int count,
                    MtlMap& map) {
    if (option == "-clamp") {
      map.clamp = lower_case(value) == "on";
    } else if (option == "-s") {
      // A missing value is 1 for the scale, 0 for the offset.
      map.scale = {count > 0 ? numbers[0] : 1, count > 1 ? numbers[1] : 1};
    } else if (option == "-o") {
      map.offset = {numbers[0], numbers[1]};
    } else if (option == "-bm") {
      map.bump = statements_.number(value, "-bm");
    } else if (option == "-imfchan" && value.size() == 1) {
      map.channel = lower_case(value).front();
    } else if (option == "-t" || option == "-boost" || (option == "-cc" && lower_case(value) == "on")) {
      ignore("option " + option);
    }
  }

  // "name.png -bm 0.2": against the format, and written.
  std::string_view without_trailing_options(std::string_view rest, MtlMap& map) {
    for (std::size_t at = rest.find(" -"); at != std::string_view::npos; at = rest.find(" -", at + 1)) {
      std::string_view options = without_blanks(rest.substr(at));
      MtlMap changed = map;
      while (options.starts_with('-') && take_option(options, changed)) options = without_blanks(options);
      if (!options.empty()) continue;
      map = changed;
      return without_blanks(rest.substr(0, at));
    }
    return rest;
  }

  void ignore(const std::string& what) {
    constexpr std::size_t kMostNotices = 50;
    if (ignored_.size() < kMostNotices) ignored_.try_emplace(in_quotes(what), statements_.line());
  }

  bool tr_must_be_opacity() const {
    const auto stands_alone = [](const MtlMaterial& m, double value) { return !m.d && m.tr == value; };
    const auto any = [&](double value) {
      return std::ranges::any_of(library_.materials, [&](const MtlMaterial& m) { return stands_alone(m, value); });
    };
    return any(1) && !any(0);
  }

  bool by_meshlab_;
  std::string name_;
  Statements statements_;
  MtlLibrary library_;
  std::map<std::string, std::size_t> ignored_;
};

}  // namespace

MtlLibrary parse_mtl(std::vector<std::byte> file, const std::string& where) {
  return MtlParser(std::move(file), where).parse();
}

}  // namespace subpixel::capture
