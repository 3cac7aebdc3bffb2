// Draws a plot. Everything is presentation attributes: a page's content policy forbids style elements.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "replay/results/plots.hpp"

namespace subpixel::replay {
namespace {

constexpr double kWidth = 760, kHeight = 460;
constexpr double kLeft = 74, kRight = 22, kTop = 44, kBottom = 58;
constexpr double kCharacter = 6.5, kLine = 13;  // of a label in 11 px

// Okabe and Ito's palette, which colour-blind people can tell apart.
constexpr std::array<std::string_view, 7> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                   "#e69f00", "#56b4e9", "#7a7a7a"};

struct Box {
  double left, top, right, bottom;
  bool overlaps(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

std::string escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else {
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

std::string short_number(double value) {
  const double size = std::abs(value);
  if (value != 0 && (size < 1e-3 || size >= 1e5)) {
    std::string text = fmt::format("{:.0e}", value);
    const std::size_t exponent = text.find('e');
    std::string sign = text[exponent + 1] == '-' ? "-" : "";
    const std::size_t digits = std::min(text.find_first_not_of('0', exponent + 2), text.size() - 1);
    return text.substr(0, exponent + 1) + sign + text.substr(digits);
  }
  return fmt::format("{:g}", value);
}

// From values to pixels along one direction. Logarithmic where the values span more than a factor of 8; equal images
// have an error of 0, which then stands at the lower end.
class Axis {
 public:
  Axis(std::vector<double> values, double from, double to) : from_(from), to_(to) {
    std::erase_if(values, [](double value) { return !std::isfinite(value); });
    if (values.empty()) values = {0, 1};
    high_ = *std::ranges::max_element(values);
    double least = high_;
    for (const double value : values) {
      has_zero_ = has_zero_ || value <= 0;
      if (value > 0) least = std::min(least, value);
    }
    logarithmic_ = least > 0 && high_ / least > 8;
    if (logarithmic_) {
      low_ = least / (has_zero_ ? 3 : 1.3);
      high_ *= 1.3;
    } else {
      low_ = 0;
      high_ = high_ > 0 ? high_ * 1.12 : 1;
    }
  }

  double at(double value) const {
    const double clamped = std::clamp(value, low_, high_);
    const double share =
        logarithmic_ ? std::log(clamped / low_) / std::log(high_ / low_) : (clamped - low_) / (high_ - low_);
    return from_ + share * (to_ - from_);
  }

  // Values with their text.
  std::vector<std::pair<double, std::string>> ticks() const {
    std::vector<std::pair<double, std::string>> ticks;
    if (logarithmic_) {
      const bool few = high_ / low_ < 300;
      for (int power = static_cast<int>(std::floor(std::log10(low_))); std::pow(10, power) <= high_; ++power) {
        for (const double digit : {1.0, 2.0, 5.0}) {
          const double value = digit * std::pow(10, power);
          if (value < low_ || value > high_ || (digit != 1 && !few)) continue;
          ticks.emplace_back(value, short_number(value));
        }
      }
      if (has_zero_) ticks.emplace_back(low_, "0");
      return ticks;
    }
    const double rough = high_ / 6;
    const double power = std::pow(10, std::floor(std::log10(rough)));
    const double step = power * (rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10);
    for (int i = 0; i * step <= high_; ++i) ticks.emplace_back(i * step, short_number(i * step));
    return ticks;
  }

 private:
  double from_, to_, low_ = 0, high_ = 1;
  bool logarithmic_ = false, has_zero_ = false;
};

std::string marker(std::size_t shape, double x, double y, std::string_view colour, bool filled) {
  const std::string paint =
      fmt::format("fill=\"{}\" stroke=\"{}\" stroke-width=\"1.6\"", filled ? colour : "none", colour);
  switch (shape % 4) {
    case 0:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.6\" {}/>", x, y, paint);
    case 1:
      return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"8.4\" height=\"8.4\" {}/>", x - 4.2, y - 4.2, paint);
    case 2:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l5.4 9.4h-10.8z\" {}/>", x, y - 5.8, paint);
    default:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l5.6 5.6l-5.6 5.6l-5.6-5.6z\" {}/>", x, y - 5.6, paint);
  }
}

// Finds places for labels near their points, clear of markers and of each other.
class Labels {
 public:
  explicit Labels(std::vector<Box> taken) : taken_(std::move(taken)) {}

  std::string place(double x, double y, const std::string& text) {
    const double width = kCharacter * static_cast<double>(text.size()) + 4;
    for (const double distance : {9.0, 16.0, 26.0, 38.0, 52.0, 68.0, 88.0, 110.0}) {
      for (const int step : {0, 8, 14, 2, 12, 4, 1, 15, 7, 9, 3, 13, 5, 11, 6, 10}) {
        const double angle = step * std::numbers::pi / 8;
        const double anchor_x = x + distance * std::cos(angle), anchor_y = y - distance * std::sin(angle);
        const double left = std::cos(angle) > 0.3    ? anchor_x
                            : std::cos(angle) < -0.3 ? anchor_x - width
                                                     : anchor_x - width / 2;
        const Box box{left, anchor_y - kLine / 2, left + width, anchor_y + kLine / 2};
        if (box.left < kLeft || box.right > kWidth - 4 || box.top < kTop - 12 || box.bottom > kHeight - kBottom)
          continue;
        if (std::ranges::any_of(taken_, [&](const Box& other) { return box.overlaps(other); })) continue;
        taken_.push_back(box);
        std::string out;
        if (distance > 16) {
          out = fmt::format(
              "<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"currentColor\" stroke-opacity=\".35\" "
              "stroke-width=\"1\"/>",
              x, y, std::clamp(x, box.left, box.right), std::clamp(y, box.top, box.bottom));
        }
        return out +
               fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", box.left + 2, anchor_y + 4, escape(text));
      }
    }
    return "";  // no room: the point's own title still says it
  }

 private:
  std::vector<Box> taken_;
};

std::string axes(const Plot& plot, const Axis& x, const Axis& y) {
  const double bottom = kHeight - kBottom, right = kWidth - kRight;
  std::string out = "<g stroke=\"currentColor\" stroke-opacity=\".13\">\n";
  std::string texts = "<g fill=\"currentColor\" fill-opacity=\".8\">\n";
  for (const auto& [value, text] : x.ticks()) {
    out += fmt::format("<path d=\"M{:.1f} {}V{}\"/>\n", x.at(value), kTop, bottom);
    texts +=
        fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", x.at(value), bottom + 16, text);
  }
  for (const auto& [value, text] : y.ticks()) {
    out += fmt::format("<path d=\"M{} {:.1f}H{}\"/>\n", kLeft, y.at(value), right);
    texts +=
        fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", kLeft - 7, y.at(value) + 4, text);
  }
  texts += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"12\">{}</text>\n",
                       (kLeft + right) / 2, kHeight - 18, escape(plot.x_title));
  texts += fmt::format(
      "<text x=\"18\" y=\"{0}\" text-anchor=\"middle\" font-size=\"12\" transform=\"rotate(-90 18 {0})\">{1}</text>\n",
      (kTop + bottom) / 2, escape(plot.y_title));
  out += fmt::format("</g>\n<path d=\"M{} {}V{}H{}\" fill=\"none\" stroke=\"currentColor\" stroke-opacity=\".6\"/>\n",
                     kLeft, kTop, bottom, right);
  return out + texts + "</g>\n";
}

// The border of what is reachable: a step where a dearer setting has less error.
std::string front(const Plot& plot, const Axis& x, const Axis& y) {
  std::vector<const PlotPoint*> points;
  for (const PlotPoint& point : plot.points) {
    if (point.on_front) points.push_back(&point);
  }
  std::ranges::sort(points, {}, &PlotPoint::x);
  if (points.empty()) return "";
  std::string path = fmt::format("M{:.1f} {}V{:.1f}", x.at(points.front()->x), kTop, y.at(points.front()->y));
  for (const PlotPoint* point : points) path += fmt::format("H{:.1f}V{:.1f}", x.at(point->x), y.at(point->y));
  return fmt::format(
      "<path class=\"front\" d=\"{}H{}\" fill=\"none\" stroke=\"currentColor\" stroke-opacity=\".45\" "
      "stroke-dasharray=\"5 4\"/>\n",
      path, kWidth - kRight);
}

}  // namespace

std::string to_svg(const Plot& plot) {
  std::vector<double> xs, ys;
  std::vector<std::string> techniques;
  for (const PlotPoint& point : plot.points) {
    xs.insert(xs.end(), {point.x, point.x_low, point.x_high});
    ys.push_back(point.y);
    if (std::ranges::find(techniques, point.technique) == techniques.end()) techniques.push_back(point.technique);
  }
  const Axis x(xs, kLeft, kWidth - kRight), y(ys, kHeight - kBottom, kTop);
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "color=\"#16202e\" "
      "font-family=\"system-ui, DejaVu Sans, sans-serif\" font-size=\"11\" role=\"img\">\n<title>{2}: {3}, "
      "{4}</title>\n"
      "<rect class=\"ground\" width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n"
      "<text x=\"{5}\" y=\"22\" font-size=\"14\" font-weight=\"600\" fill=\"currentColor\">{2}</text>\n",
      kWidth, kHeight, escape(plot.title), escape(plot.x_title), escape(plot.y_title), kLeft);
  if (plot.points.empty()) {
    return out + fmt::format(
                     "<text x=\"{}\" y=\"{}\" fill=\"currentColor\">Nothing was measured that could be drawn "
                     "here.</text>\n</svg>\n",
                     kLeft, kHeight / 2);
  }
  out += axes(plot, x, y) + front(plot, x, y);
  std::vector<Box> taken;
  std::string marks;
  bool any_bar = false;
  for (const PlotPoint& point : plot.points) {
    const auto which = static_cast<std::size_t>(std::ranges::find(techniques, point.technique) - techniques.begin());
    const std::string_view colour = kColours[which % kColours.size()];
    const double px = x.at(point.x), py = y.at(point.y);
    std::string bar;
    if (point.x_high > point.x_low) {
      bar = fmt::format("<path d=\"M{0:.1f} {2:.1f}v6M{0:.1f} {3:.1f}H{1:.1f}M{1:.1f} {2:.1f}v6\" stroke=\"{4}\"/>",
                        x.at(point.x_low), x.at(point.x_high), py - 3, py, colour);
    }
    any_bar = any_bar || !bar.empty();
    if (!bar.empty()) taken.push_back({x.at(point.x_low), py - 2, x.at(point.x_high), py + 2});
    taken.push_back({px - 6, py - 6, px + 6, py + 6});
    marks += fmt::format("<g class=\"point\"><title>{}: {:.4g}, {:.4g}{}</title>{}{}</g>\n", escape(point.label),
                         point.x, point.y, point.on_front ? ", on the front" : "", bar,
                         marker(which, px, py, colour, point.on_front));
  }
  Labels labels(std::move(taken));
  std::string texts;
  // What is on the front has the first choice of places.
  for (const bool on_front : {true, false}) {
    for (const PlotPoint& point : plot.points) {
      if (point.on_front == on_front) texts += labels.place(x.at(point.x), y.at(point.y), point.label);
    }
  }
  return out + marks +
         fmt::format(
             "<g class=\"labels\" fill=\"currentColor\" stroke=\"#ffffff\" stroke-width=\"3\" "
             "paint-order=\"stroke\">\n{}</g>\n",
             texts) +
         fmt::format(
             "<text x=\"{}\" y=\"22\" text-anchor=\"end\" fill=\"currentColor\" fill-opacity=\".7\">filled: on the "
             "Pareto front{}</text>\n</svg>\n",
             kWidth - kRight, any_bar ? "; bars: spread of the repeats" : "");
}

}  // namespace subpixel::replay
